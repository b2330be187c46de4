// Which plug-in of an interface, and the parameters of each: how a configuration names one.
#pragma once
#include <map>
#include <memory>
#include <string>

#include "scslam/core/registry.h"

namespace scslam {

/// A choice among the plug-ins of one interface, with a group of parameters for each of them.
template <class Interface>
struct PluginChoice {
  std::string name;
  std::map<std::string, std::unique_ptr<ParamSet>> params;

  explicit PluginChoice(std::string chosen) : name(std::move(chosen)) {
    for (const auto& plugin : Registry<Interface>::instance().names())
      params[plugin] = Registry<Interface>::instance().find(plugin).defaults();
  }
  PluginChoice(const PluginChoice& other) : name(other.name) {
    for (const auto& [plugin, values] : other.params) params[plugin] = values->clone();
  }
  PluginChoice& operator=(const PluginChoice& other) {
    PluginChoice copy(other);
    std::swap(name, copy.name);
    std::swap(params, copy.params);
    return *this;
  }
  void describe(ParamVisitor& v, const char* key, const char* doc) {
    v.field(key, name, doc, Registry<Interface>::instance().names());
    describeGroups(v);
  }
  void describeGroups(ParamVisitor& v) {
    for (auto& [plugin, values] : params)
      v.group(plugin.c_str(), *values, Registry<Interface>::instance().find(plugin).summary.c_str());
  }
  std::unique_ptr<Interface> create(const PluginContext& context) const {
    return Registry<Interface>::instance().create(name, *params.at(name), context);
  }
};

/// Several plug-ins of one interface side by side.
template <class Interface>
struct PluginList {
  std::vector<std::string> names;
  PluginChoice<Interface> parameters{""};

  explicit PluginList(std::vector<std::string> chosen) : names(std::move(chosen)) {}
  void describe(ParamVisitor& v, const char* key, const char* doc) {
    v.field(key, names, doc, Registry<Interface>::instance().names());
    parameters.describeGroups(v);
  }
  std::vector<std::unique_ptr<Interface>> create(const PluginContext& context) const {
    std::vector<std::unique_ptr<Interface>> result;
    for (const auto& name : names)
      result.push_back(Registry<Interface>::instance().create(name, *parameters.params.at(name), context));
    return result;
  }
};

}  // namespace scslam
