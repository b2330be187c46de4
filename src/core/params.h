// Parameters: plain structs with defaults that describe themselves once; loading, checking, dumping and the schema
// follow.
#pragma once
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace scslam {

/// Visits the fields of a parameter struct. Angles carry a key that ends in _deg, lengths _m, times _s.
class ParamVisitor {
 public:
  virtual ~ParamVisitor() = default;
  static constexpr double kInf = std::numeric_limits<double>::infinity();
  /// @param doc one line with the unit. Values outside [lo, hi] are refused with the line and column.
  virtual void field(const char* key, double& value, const char* doc, double lo = -kInf, double hi = kInf) = 0;
  virtual void field(const char* key, int& value, const char* doc, int lo = 0, int hi = 2147483647) = 0;
  virtual void field(const char* key, bool& value, const char* doc) = 0;
  /// @param choices when not empty, the only values allowed.
  virtual void field(const char* key, std::string& value, const char* doc,
                     const std::vector<std::string>& choices = {}) = 0;
  virtual void field(const char* key, std::vector<double>& value, const char* doc) = 0;
  /// A list without repetitions. @param choices the only values allowed.
  virtual void field(const char* key, std::vector<std::string>& value, const char* doc,
                     const std::vector<std::string>& choices) = 0;
  virtual void group(const char* key, class ParamSet& params, const char* doc) = 0;
};

class ParamSet {
 public:
  virtual ~ParamSet() = default;
  virtual void describe(ParamVisitor& visitor) = 0;
  virtual std::unique_ptr<ParamSet> clone() const = 0;
};

/// struct Params : ParamSetOf<Params> { double voxel_m = 1.0; void describe(ParamVisitor& v) override { … } };
template <class Derived>
struct ParamSetOf : ParamSet {
  std::unique_ptr<ParamSet> clone() const override {
    return std::make_unique<Derived>(static_cast<const Derived&>(*this));
  }
};

/// Reads a YAML text into `params`. Keys that are absent keep their value.
/// @param source the file's name, for messages.
/// @throw usageError "source:line:column: …" for malformed YAML, unknown keys (with a suggestion), wrong types, values
/// out of range.
void loadYaml(ParamSet& params, const std::string& text, const std::string& source);
/// Sets one field from the command line. @param assignment "registration.voxel_m=0.5".
void setParam(ParamSet& params, const std::string& assignment);
/// The resolved values as YAML; with `documented`, each key's doc and range as a comment. loadYaml reads it back to the
/// same values.
std::string dumpYaml(const ParamSet& params, bool documented = false);
/// JSON schema of the YAML file.
std::string schemaJson(const ParamSet& params);

}  // namespace scslam
