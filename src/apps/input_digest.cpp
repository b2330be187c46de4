#include "scslam/apps/input_digest.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace scslam {

std::string inputDigest(const std::filesystem::path& input, std::size_t skip) {
  namespace fs = std::filesystem;
  std::vector<std::string> lines;
  std::error_code ignored;
  if (fs::is_directory(input, ignored)) {
    for (fs::recursive_directory_iterator it(input, fs::directory_options::skip_permission_denied, ignored), end;
         it != end; it.increment(ignored)) {
      if (it->is_regular_file(ignored))
        lines.push_back(
            fmt::format("{} {}", fs::relative(it->path(), input, ignored).string(), it->file_size(ignored)));
    }
  } else {
    lines.push_back(fmt::format("{} {}", input.filename().string(),
                                fs::exists(input, ignored) ? fs::file_size(input, ignored) : 0));
  }
  std::sort(lines.begin(), lines.end());
  lines.push_back(fmt::format("skip {}", skip));
  std::uint64_t hash = 0xcbf29ce484222325ULL;  // FNV-1a
  for (const auto& line : lines)
    for (const char c : line + "\n") hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return fmt::format("{:016x}", hash);
}

}  // namespace scslam
