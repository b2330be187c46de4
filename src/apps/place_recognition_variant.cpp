#include <algorithm>
#include <string_view>

#include "scslam/apps/place_recognition.h"

namespace scslam {
namespace {

constexpr std::string_view kThreshold = "max_distance", kMinTravel = "min_travel_m", kCandidates = "candidates";

/// Sets what the measurement decides, in recognisers that have these parameters.
class Opener : public ParamVisitor {
 public:
  explicit Opener(const PlaceOptions& options) : options_(options) {}
  void field(const char* key, double& value, const char*, double lo, double hi) override {
    if (key == kThreshold) value = hi;
    if (key == kMinTravel) value = std::clamp(options_.min_travel_m, lo, hi);
  }
  void field(const char* key, int& value, const char*, int, int hi) override {
    if (key == kCandidates) value = std::max(value, std::min(5, hi));
  }
  void field(const char*, bool&, const char*) override {}
  void field(const char*, std::string&, const char*, const std::vector<std::string>&) override {}
  void field(const char*, std::vector<double>&, const char*) override {}
  void field(const char*, std::vector<std::string>&, const char*, const std::vector<std::string>&) override {}
  void group(const char*, ParamSet& params, const char*) override { params.describe(*this); }

 private:
  PlaceOptions options_;
};

/// At commas that do not stand inside brackets.
std::vector<std::string> splitAssignments(std::string_view text) {
  std::vector<std::string> parts(1);
  int depth = 0;
  for (const char c : text) {
    depth += c == '[' ? 1 : c == ']' ? -1 : 0;
    if (c == ',' && depth == 0)
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

}  // namespace

PlaceVariant placeVariant(const std::string& text, const SlamParams& config, const PlaceOptions& options) {
  const std::size_t colon = text.find(':');
  PlaceVariant variant;
  variant.label = text;
  variant.recogniser = text.substr(0, colon);
  Registry<PlaceRecogniser>::instance().find(variant.recogniser);
  SlamParams params = config;
  if (colon != std::string::npos)
    for (const std::string& assignment : splitAssignments(std::string_view(text).substr(colon + 1))) {
      const std::string key = assignment.substr(0, assignment.find('='));
      if (key == kThreshold)
        throw usageError("--variant {}: {} is what the curve runs over, leave it out", text, kThreshold);
      if (key == kMinTravel) throw usageError("--variant {}: give --min-travel, which holds for truth and all", text);
      setParam(params, fmt::format("place.{}.{}", variant.recogniser, assignment));
    }
  std::unique_ptr<ParamSet> own = params.place.recognisers.parameters.params.at(variant.recogniser)->clone();
  Opener opener(options);
  own->describe(opener);
  variant.params = std::move(own);
  return variant;
}

}  // namespace scslam
