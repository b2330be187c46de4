#include "scslam/session/manifest.h"

#include <yaml-cpp/yaml.h>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/session/layout.h"

namespace scslam {
namespace {

constexpr int kVersion = 1;

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      (result += '\\') += c;
    else if (static_cast<unsigned char>(c) < 0x20)
      result += fmt::format("\\x{:02x}", static_cast<unsigned>(static_cast<unsigned char>(c)));
    else
      result += c;
  }
  return result + '"';
}

std::string numbers(const Pose& T) {
  std::string text = "[";
  for (int i = 0; i < 12; ++i) text += fmt::format("{}{:.17g}", i == 0 ? "" : ", ", T.matrix()(i / 4, i % 4));
  return text + "]";
}

Pose poseOf(const YAML::Node& node) {
  const auto values = node.as<std::vector<double>>();
  if (values.size() != 12) throw YAML::Exception(node.Mark(), "T_base_sensor needs 12 numbers");
  Pose T = Pose::Identity();
  for (int i = 0; i < 12; ++i) T.matrix()(i / 4, i % 4) = values[static_cast<std::size_t>(i)];
  if (!isRigid(T)) throw YAML::Exception(node.Mark(), "T_base_sensor is no rigid motion");
  return T;
}

std::string formatParents(const std::vector<SessionParent>& parents) {
  if (parents.empty()) return "";
  std::string text = "parents:\n";
  for (const SessionParent& parent : parents) {
    text += fmt::format("  - {{name: {}, digest: {}, leaves: [", quoted(parent.name), quoted(parent.digest));
    for (std::size_t i = 0; i < parent.leaves.size(); ++i) text += (i > 0 ? ", " : "") + quoted(parent.leaves[i]);
    text += "]}\n";
  }
  return text;
}

std::vector<SessionParent> parentsOf(const YAML::Node& list) {
  std::vector<SessionParent> parents;
  for (const YAML::Node& node : list)
    parents.push_back({node["name"].as<std::string>(), node["digest"].as<std::string>(),
                       node["leaves"].as<std::vector<std::string>>()});
  return parents;
}

/// @throw YAML::Exception where a key is missing or has the wrong type.
Manifest parse(const YAML::Node& root) {
  const auto need = [&](const char* key) {
    if (!root.IsMap() || !root[key]) throw YAML::Exception(root.Mark(), fmt::format("'{}' is missing", key));
    return root[key];
  };
  if (const int version = need("version").as<int>(); version != kVersion)
    throw YAML::Exception(root["version"].Mark(),
                          fmt::format("version {}; this program reads version {}", version, kVersion));
  Manifest manifest;
  const auto state = need("state").as<std::string>();
  if (state != "open" && state != "complete")
    throw YAML::Exception(root["state"].Mark(), fmt::format("state '{}' is neither open nor complete", state));
  manifest.complete = state == "complete";
  SessionInfo& info = manifest.info;
  info.input = need("input").as<std::string>();
  info.input_format = need("format").as<std::string>();
  info.input_digest = need("input_digest").as<std::string>();
  manifest.config_digest = need("config_digest").as<std::string>();
  info.odometry = need("odometry").as<std::string>();
  info.recogniser = need("recogniser").as<std::string>();
  info.registration = need("registration").as<std::string>();
  info.sensor_label = need("sensor").as<std::string>();
  if (root["sensor_table"]) info.sensor_table = root["sensor_table"].as<std::string>();
  info.T_base_sensor = poseOf(need("T_base_sensor"));
  info.planar = need("planar").as<bool>();
  if (root["parents"]) info.parents = parentsOf(root["parents"]);
  manifest.scans = need("scans").as<std::size_t>();
  manifest.keyframes = need("keyframes").as<std::size_t>();
  manifest.loops_accepted = need("loops_accepted").as<std::size_t>();
  return manifest;
}

}  // namespace

std::string digestOf(std::string_view text) {
  std::uint64_t hash = 14695981039346656037u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211u;
  return fmt::format("{:016x}", hash);
}

std::string formatManifest(const Manifest& manifest) {
  const SessionInfo& info = manifest.info;
  return fmt::format(
      "version: {}\nstate: {}\ninput: {}\nformat: {}\ninput_digest: {}\nconfig_digest: {}\nodometry: {}\n"
      "recogniser: {}\nregistration: {}\nsensor: {}\n"
      "{}# row-major 3x4: p_base = T_base_sensor * p_sensor\n"
      "T_base_sensor: {}\nplanar: {}\nscans: {}\nkeyframes: {}\nloops_accepted: {}\n{}",
      kVersion, manifest.complete ? "complete" : "open", quoted(info.input), quoted(info.input_format),
      quoted(info.input_digest), quoted(digestOf(info.config_yaml)), quoted(info.odometry), quoted(info.recogniser),
      quoted(info.registration), quoted(info.sensor_label),
      info.sensor_table.empty() ? "" : fmt::format("sensor_table: {}\n", quoted(info.sensor_table)),
      numbers(info.T_base_sensor), info.planar, manifest.scans, manifest.keyframes, manifest.loops_accepted,
      formatParents(info.parents));
}

Manifest readManifest(const std::filesystem::path& folder) {
  const auto file = folder / layout::kManifest;
  const std::string text = readFile(file, std::size_t{1} << 20);
  Manifest manifest;
  try {
    manifest = parse(YAML::Load(text));
  } catch (const YAML::Exception& error) {
    throw inputError("{}:{}:{}: {}", file.string(), error.mark.line + 1, error.mark.column + 1, error.msg);
  }
  if (const auto config = folder / layout::kConfig; std::filesystem::exists(config))
    manifest.info.config_yaml = readFile(config, std::size_t{1} << 24);
  return manifest;
}

}  // namespace scslam
