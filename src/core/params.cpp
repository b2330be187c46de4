#include "scslam/core/params.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>

#include "scslam/core/error.h"
#include "scslam/core/suggest.h"

namespace scslam {
namespace {

template <class T>
const char* typeName() {
  if constexpr (std::is_same_v<T, double>) return "a number";
  if constexpr (std::is_same_v<T, int>) return "a whole number";
  if constexpr (std::is_same_v<T, bool>) return "true or false";
  return "a text";
}

/// Fills the struct from one YAML map; every key must belong to a field.
class Loader : public ParamVisitor {
 public:
  Loader(const YAML::Node& map, std::string source, std::string path)
      : map_(map), source_(std::move(source)), path_(std::move(path)) {
    if (map_.IsNull()) return;
    if (!map_.IsMap())
      throw usageError("{}: {} must be a list of 'key: value'", where(map_),
                       path_.empty() ? "the file" : "'" + path_ + "'");
    for (auto a = map_.begin(); a != map_.end(); ++a)
      for (auto b = map_.begin(); b != a; ++b)
        if (a->first.Scalar() == b->first.Scalar())
          throw usageError("{}: key '{}' stands twice", where(a->first), a->first.Scalar());
  }

  void field(const char* key, double& value, const char*, double lo, double hi) override { ranged(key, value, lo, hi); }
  void field(const char* key, int& value, const char*, int lo, int hi) override { ranged(key, value, lo, hi); }
  void field(const char* key, bool& value, const char*) override { read(key, value); }
  void field(const char* key, std::string& value, const char*, const std::vector<std::string>& choices) override {
    const YAML::Node node = read(key, value);
    if (node && !choices.empty()) checkChoice(node, key, value, choices);
  }
  void field(const char* key, std::vector<double>& value, const char*) override {
    const YAML::Node node = find(key);
    if (!node) return;
    if (!node.IsSequence()) throw usageError("{}: {} must be a list of numbers: [1, 2, 3]", where(node), full(key));
    std::vector<double> numbers;
    for (const auto& item : node) numbers.push_back(parse<double>(item, key));
    value = std::move(numbers);
  }
  void field(const char* key, std::vector<std::string>& value, const char*,
             const std::vector<std::string>& choices) override {
    const YAML::Node node = find(key);
    if (!node) return;
    if (!node.IsSequence() && !node.IsScalar())
      throw usageError("{}: {} must be a list of names: [one, two]", where(node), full(key));
    std::vector<std::string> names;
    const auto take = [&](const YAML::Node& item) {
      names.push_back(parse<std::string>(item, key));
      checkChoice(item, key, names.back(), choices);
      if (std::count(names.begin(), names.end(), names.back()) > 1)
        throw usageError("{}: {} names '{}' twice", where(item), full(key), names.back());
    };
    if (node.IsScalar()) take(node);
    for (const auto& item : node) take(item);
    value = std::move(names);
  }
  void group(const char* key, ParamSet& params, const char*) override {
    const YAML::Node node = find(key);
    if (!node) return;
    Loader inner(node, source_, full(key));
    params.describe(inner);
    inner.refuseUnknown();
  }

  void refuseUnknown() const {
    if (!map_.IsMap()) return;
    for (const auto& entry : map_) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
      if (std::find(known_.begin(), known_.end(), key) == known_.end())
        throw usageError("{}: unknown key '{}'{}", where(entry.first), path_.empty() ? key : path_ + "." + key,
                         didYouMean(key, known_));
    }
  }

 private:
  std::string where(const YAML::Node& node) const {
    const YAML::Mark mark = node.Mark();
    if (source_.starts_with("--set") || mark.line < 0) return source_;
    return fmt::format("{}:{}:{}", source_, mark.line + 1, mark.column + 1);
  }
  std::string full(const char* key) const { return path_.empty() ? key : path_ + "." + key; }

  void checkChoice(const YAML::Node& node, const char* key, const std::string& value,
                   const std::vector<std::string>& choices) const {
    if (std::find(choices.begin(), choices.end(), value) == choices.end())
      throw usageError("{}: {} cannot be '{}'{}", where(node), full(key), value, didYouMean(value, choices));
  }

  YAML::Node find(const char* key) {
    known_.emplace_back(key);
    if (!map_.IsMap()) return YAML::Node(YAML::NodeType::Undefined);
    const YAML::Node& map = map_;  // the const operator[] does not insert
    return map[key];
  }

  template <class T>
  T parse(const YAML::Node& node, const char* key) const {
    if constexpr (std::is_same_v<T, std::string>) {
      if (node.IsNull()) return "";  // "key:" and "key: ''" both mean the empty text
    }
    T value{};
    if (!node.IsScalar() || !YAML::convert<T>::decode(node, value))
      throw usageError("{}: {} must be {}{}", where(node), full(key), typeName<T>(),
                       node.IsScalar() ? ", not '" + node.Scalar() + "'" : "");
    if constexpr (std::is_same_v<T, double>)
      if (std::isnan(value)) throw usageError("{}: {} must be a number, not NaN", where(node), full(key));
    return value;
  }

  template <class T>
  YAML::Node read(const char* key, T& value) {
    const YAML::Node node = find(key);
    if (node) value = parse<T>(node, key);
    return node;
  }

  template <class T>
  void ranged(const char* key, T& value, T lo, T hi) {
    const YAML::Node node = read(key, value);
    if (node && (value < lo || value > hi))
      throw usageError("{}: {} = {} is outside [{}, {}]", where(node), full(key), value, lo, hi);
  }

  YAML::Node map_;
  std::string source_, path_;
  std::vector<std::string> known_;
};

std::string quoted(const std::string& text) {
  YAML::Emitter emitter;
  emitter << YAML::DoubleQuoted << text;
  return emitter.c_str();
}

class Dumper : public ParamVisitor {
 public:
  explicit Dumper(bool documented) : documented_(documented) {}
  void field(const char* key, double& value, const char* doc, double lo, double hi) override {
    line(key, number(value), doc, range(lo, hi));
  }
  void field(const char* key, int& value, const char* doc, int lo, int hi) override {
    line(key, std::to_string(value), doc, range(lo, hi == 2147483647 ? kInf : double(hi)));
  }
  void field(const char* key, bool& value, const char* doc) override { line(key, value ? "true" : "false", doc, ""); }
  void field(const char* key, std::string& value, const char* doc, const std::vector<std::string>& choices) override {
    line(key, quoted(value), doc, choices.empty() ? "" : fmt::format(" ({})", fmt::join(choices, ", ")));
  }
  void field(const char* key, std::vector<double>& value, const char* doc) override {
    std::string list;
    for (const double v : value) list += (list.empty() ? "" : ", ") + number(v);
    line(key, "[" + list + "]", doc, "");
  }
  void field(const char* key, std::vector<std::string>& value, const char* doc,
             const std::vector<std::string>& choices) override {
    std::string list;
    for (const std::string& v : value) list += (list.empty() ? "" : ", ") + quoted(v);
    line(key, "[" + list + "]", doc, fmt::format(" ({})", fmt::join(choices, ", ")));
  }
  void group(const char* key, ParamSet& params, const char* doc) override {
    const std::size_t before = text.size();
    text += indent() + key + ":" + (documented_ ? fmt::format("  # {}", doc) : "") + "\n";
    const std::size_t head = text.size();
    ++depth_;
    params.describe(*this);
    --depth_;
    if (text.size() == head) text.resize(before);  // a plug-in without parameters
  }
  std::string text;

 private:
  std::string indent() const { return std::string(2 * depth_, ' '); }
  static std::string number(double value) {
    if (std::isinf(value)) return value > 0 ? ".inf" : "-.inf";
    return fmt::format("{}", value);  // shortest text that reads back to the same double
  }
  static std::string range(double lo, double hi) {
    return std::isinf(lo) && std::isinf(hi) ? "" : fmt::format(" [{} .. {}]", lo, hi);
  }
  void line(const char* key, const std::string& value, const char* doc, const std::string& extra) {
    text += fmt::format("{}{}: {}", indent(), key, value);
    if (documented_) text += fmt::format("  # {}{}", doc, extra);
    text += '\n';
  }
  bool documented_;
  std::size_t depth_ = 0;
};

class SchemaWriter : public ParamVisitor {
 public:
  void field(const char* key, double& value, const char* doc, double lo, double hi) override {
    std::string type = R"("type": "number")";
    if (!std::isinf(lo)) type += fmt::format(R"(, "minimum": {})", lo);
    if (!std::isinf(hi)) type += fmt::format(R"(, "maximum": {})", hi);
    if (std::isfinite(value)) type += fmt::format(R"(, "default": {})", value);
    entry(key, type, doc);
  }
  void field(const char* key, int& value, const char* doc, int lo, int hi) override {
    entry(key, fmt::format(R"("type": "integer", "minimum": {}, "maximum": {}, "default": {})", lo, hi, value), doc);
  }
  void field(const char* key, bool& value, const char* doc) override {
    entry(key, fmt::format(R"("type": "boolean", "default": {})", value), doc);
  }
  void field(const char* key, std::string& value, const char* doc, const std::vector<std::string>& choices) override {
    std::string type = R"("type": "string", "default": )" + quoted(value);
    if (!choices.empty()) type += ", " + oneOf(choices);
    entry(key, type, doc);
  }
  void field(const char* key, std::vector<double>&, const char* doc) override {
    entry(key, R"("type": "array", "items": {"type": "number"})", doc);
  }
  void field(const char* key, std::vector<std::string>&, const char* doc,
             const std::vector<std::string>& choices) override {
    entry(key, R"("type": "array", "uniqueItems": true, "items": {"type": "string", )" + oneOf(choices) + "}", doc);
  }
  void group(const char* key, ParamSet& params, const char* doc) override {
    SchemaWriter inner;
    params.describe(inner);
    entry(key, inner.object(), doc);
  }
  std::string object() const {
    return fmt::format(R"("type": "object", "additionalProperties": false, "properties": {{{}}})", properties_);
  }

 private:
  static std::string oneOf(const std::vector<std::string>& choices) {
    std::string list;
    for (const auto& choice : choices) list += (list.empty() ? "" : ", ") + quoted(choice);
    return R"("enum": [)" + list + "]";
  }
  void entry(const char* key, const std::string& type, const char* doc) {
    properties_ +=
        fmt::format("{}\"{}\": {{{}, \"description\": {}}}", properties_.empty() ? "" : ", ", key, type, quoted(doc));
  }
  std::string properties_;
};

YAML::Node parseYaml(const std::string& text, const std::string& source) {
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw usageError("{}:{}:{}: not YAML: {}", source, error.mark.line + 1, error.mark.column + 1, error.msg);
  }
}

}  // namespace

void loadYaml(ParamSet& params, const std::string& text, const std::string& source) {
  Loader loader(parseYaml(text, source), source, "");
  params.describe(loader);
  loader.refuseUnknown();
}

void setParam(ParamSet& params, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0)
    throw usageError("--set {}: must look like section.key=value", assignment);
  std::string text, path = assignment.substr(0, equals);
  std::size_t braces = 0;
  for (std::size_t dot; (dot = path.find('.')) != std::string::npos; path = path.substr(dot + 1), ++braces)
    text += quoted(path.substr(0, dot)) + ": {";
  text += quoted(path) + ": " + assignment.substr(equals + 1) + std::string(braces, '}');
  loadYaml(params, text, "--set " + assignment);
}

std::string dumpYaml(const ParamSet& params, bool documented) {
  Dumper dumper(documented);
  params.clone()->describe(dumper);
  return dumper.text;
}

std::string schemaJson(const ParamSet& params) {
  SchemaWriter writer;
  params.clone()->describe(writer);
  return fmt::format("{{\"$schema\": \"http://json-schema.org/draft-07/schema#\", {}}}\n", writer.object());
}

}  // namespace scslam
