#include "scslam/session/checkpoint.h"

#include "scslam/core/bytes.h"
#include "scslam/core/error.h"
#include "scslam/core/file.h"

namespace scslam {
namespace {

constexpr std::string_view kMagic = "SCSLAMCP";
constexpr std::uint32_t kVersion = 1;

}  // namespace

void writeCheckpoint(const std::filesystem::path& file, const Checkpoint& checkpoint) {
  ByteWriter body;
  body.put(kVersion);
  body.put(checkpoint.journal_bytes);
  body.put(checkpoint.log_bytes);
  body.put(std::uint64_t{checkpoint.T_map_base.size()});
  for (const Pose& T : checkpoint.T_map_base) body.put(T);
  body.put(checkpoint.pipeline_state);
  ByteWriter crc;
  crc.put(crc32Of(body.bytes()));
  writeFileAtomically(file, std::string(kMagic) + crc.bytes() + body.bytes());
}

std::optional<Checkpoint> readCheckpoint(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return std::nullopt;
  const std::string bytes = readFile(file);
  constexpr std::size_t kPrefix = kMagic.size() + sizeof(std::uint32_t);
  if (bytes.size() < kPrefix || bytes.compare(0, kMagic.size(), kMagic) != 0)
    throw inputError("{} is no checkpoint", file.string());
  const auto crc = ByteReader(std::string_view(bytes).substr(kMagic.size())).get<std::uint32_t>();
  const std::string_view body = std::string_view(bytes).substr(kPrefix);
  if (crc32Of(body) != crc) throw inputError("{} is damaged (its checksum is wrong)", file.string());
  ByteReader in(body);
  if (const auto version = in.get<std::uint32_t>(); version != kVersion)
    throw inputError("{} has version {}; this program reads version {}", file.string(), version, kVersion);
  Checkpoint checkpoint;
  in.get(checkpoint.journal_bytes);
  in.get(checkpoint.log_bytes);
  const auto poses = in.get<std::uint64_t>();
  if (poses > in.remaining() / (12 * sizeof(double))) throw inputError("{} is damaged", file.string());
  checkpoint.T_map_base.resize(poses);
  for (Pose& T : checkpoint.T_map_base) in.get(T);
  in.get(checkpoint.pipeline_state);
  return checkpoint;
}

}  // namespace scslam
