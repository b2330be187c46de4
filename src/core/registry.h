// A folder is a registry: one file that ends in SCSLAM_REGISTER(...) adds one plug-in (CONTRIBUTING.md).
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "scslam/core/error.h"
#include "scslam/core/params.h"
#include "scslam/core/suggest.h"

namespace mrpt::system {
class COutputLogger;
}

namespace scslam {

class ThreadPool;

/// What every plug-in is given besides its own parameters. The references outlive the plug-in.
struct PluginContext {
  ThreadPool& threads;
  mrpt::system::COutputLogger& log;
};

/// The plug-ins of one interface, by name. Filled before main() by SCSLAM_REGISTER, then only read (and by --plugin).
template <class Interface>
class Registry {
 public:
  struct Entry {
    std::string name;
    std::string summary;                                  ///< one line, shown by `scslam list`
    std::function<std::unique_ptr<ParamSet>()> defaults;  ///< the plug-in's own parameters
    std::function<std::unique_ptr<Interface>(const ParamSet&, const PluginContext&)> create;
  };

  static Registry& instance();

  void add(Entry entry) { entries_[entry.name] = std::move(entry); }

  /// In alphabetical order.
  std::vector<std::string> names() const {
    std::vector<std::string> result;
    for (const auto& [name, entry] : entries_) result.push_back(name);
    return result;
  }

  /// @throw usageError that names the nearest registered plug-in.
  const Entry& find(const std::string& name) const {
    if (auto it = entries_.find(name); it != entries_.end()) return it->second;
    throw usageError("no {} is called '{}'{}", Interface::kKind, name, didYouMean(name, names()));
  }

  std::unique_ptr<Interface> create(const std::string& name, const ParamSet& params,
                                    const PluginContext& context) const {
    return find(name).create(params, context);
  }
  /// With the plug-in's default parameters.
  std::unique_ptr<Interface> create(const std::string& name, const PluginContext& context) const {
    return create(name, *find(name).defaults(), context);
  }

 private:
  std::map<std::string, Entry> entries_;
};

/// One instance per interface in the whole process, also across --plugin libraries: each interface's .cpp defines it
/// with SCSLAM_DEFINE_REGISTRY.
#define SCSLAM_DEFINE_REGISTRY(Interface)                                \
  template <>                                                            \
  scslam::Registry<Interface>& scslam::Registry<Interface>::instance() { \
    static scslam::Registry<Interface> registry;                         \
    return registry;                                                     \
  }
#define SCSLAM_DECLARE_REGISTRY(Interface) \
  template <>                              \
  scslam::Registry<Interface>& scslam::Registry<Interface>::instance()

/// Plug-in `Class` has `struct Params : ParamSetOf<Params>` and a constructor (const Params&, const PluginContext&).
#define SCSLAM_REGISTER(Interface, Class, Name, Summary)                                                              \
  namespace {                                                                                                         \
  const bool SCSLAM_JOINED(registered_at_line_, __LINE__) = [] {                                                      \
    ::scslam::Registry<Interface>::instance().add(                                                                    \
        {Name, Summary, [] { return std::make_unique<Class::Params>(); },                                             \
         [](const ::scslam::ParamSet& params, const ::scslam::PluginContext& context) -> std::unique_ptr<Interface> { \
           return std::make_unique<Class>(dynamic_cast<const Class::Params&>(params), context);                       \
         }});                                                                                                         \
    return true;                                                                                                      \
  }();                                                                                                                \
  }
#define SCSLAM_JOINED(a, b) SCSLAM_JOINED_(a, b)
#define SCSLAM_JOINED_(a, b) a##b

}  // namespace scslam
