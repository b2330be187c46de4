#include "scslam/sensor/scan_source.h"

#include "scslam/core/error.h"

namespace scslam {

SCSLAM_DEFINE_REGISTRY(ScanFormat)

void ScanSource::skip(std::size_t n) {
  for (std::size_t i = 0; i < n; ++i)
    if (!next()) return;
}

namespace {

void refuseWhatIsNotThere(const std::filesystem::path& uri) {
  std::error_code error;
  const auto status = std::filesystem::status(uri, error);
  if (!std::filesystem::exists(status)) throw inputError("{} does not exist", uri.string());
  if (std::filesystem::is_directory(status)) {
    const std::filesystem::directory_iterator entries(uri, error);
    if (error) throw inputError("cannot read folder {}: {}", uri.string(), error.message());
    if (entries == std::filesystem::directory_iterator()) throw inputError("folder {} is empty", uri.string());
  } else if (std::filesystem::is_regular_file(status) && std::filesystem::file_size(uri, error) == 0) {
    throw inputError("{} is empty (0 bytes)", uri.string());
  }
}

}  // namespace

OpenedSource openSource(const std::filesystem::path& uri, const PluginContext& context, const OpenOptions& options) {
  refuseWhatIsNotThere(uri);
  const auto& registry = Registry<ScanFormat>::instance();
  OpenedSource best;
  std::unique_ptr<ScanFormat> best_format;
  int best_confidence = 0;
  std::string looked_for;
  constexpr int kPreferred = 1000;  // above every confidence
  for (const std::string& name : registry.names()) {
    auto format = registry.create(name, context);
    auto guess = format->probe(uri);
    if (options.radar && guess.radar) guess.confidence += kPreferred;
    if (guess.confidence > best_confidence) {
      best_confidence = guess.confidence;
      best_format = std::move(format);
      best.format = name;
      best.why = guess.why;
    }
    looked_for += fmt::format("{}{} ({})", looked_for.empty() ? "" : ", ", name, registry.find(name).summary);
  }
  if (!best_format) throw inputError("{}: no known input; looked for: {}", uri.string(), looked_for);
  best.source = best_format->open(uri, options);
  return best;
}

}  // namespace scslam
