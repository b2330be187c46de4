#include "scslam/sensor/cloud_files.h"

#include <cstring>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/pcd.h"
#include "scslam/sensor/scan_files.h"

namespace scslam {

Cloud readXyziBin(const std::filesystem::path& file) {
  constexpr std::size_t kRecord = 16;
  const std::string bytes = readFile(file);
  if (bytes.size() % kRecord != 0)
    throw inputError("{}: {} bytes are no whole number of 16-byte points (float32 x y z intensity); cut at byte {}?",
                     file.string(), bytes.size(), bytes.size());
  const std::size_t n = bytes.size() / kRecord;
  Cloud cloud;
  cloud.resize(n);
  cloud.intensity.resize(n);
  const char* p = bytes.data();
  for (std::size_t i = 0; i < n; ++i, p += kRecord) {
    float v[4];
    std::memcpy(v, p, kRecord);
    cloud.x[i] = v[0], cloud.y[i] = v[1], cloud.z[i] = v[2], cloud.intensity[i] = v[3];
  }
  return cloud;
}

Cloud readXyzText(const std::filesystem::path& file) {
  const TextTable table = readTextTable(file);
  Cloud cloud;
  const bool intensity = !table.rows.empty() && table.rows[0].cells.size() > 3;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    if (table.rows[i].cells.size() != table.rows[0].cells.size())
      throw inputError("{}:{}: {} columns, the lines above have {}", file.string(), table.rows[i].line,
                       table.rows[i].cells.size(), table.rows[0].cells.size());
    const auto value = [&](std::size_t column) { return static_cast<float>(table.number(i, column)); };
    cloud.push(value(0), value(1), value(2));
    if (intensity) cloud.intensity.push_back(value(3));
  }
  return cloud;
}

Cloud readCloudFile(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  if (extension == ".pcd") return readPcd(file);
  if (extension == ".ply") return readPly(file);
  if (extension == ".bin") return readXyziBin(file);
  if (extension == ".xyz" || extension == ".txt" || extension == ".csv") return readXyzText(file);
  throw inputError("{}: '{}' is no known cloud file (.pcd .ply .bin .xyz .txt .csv)", file.string(), extension);
}

}  // namespace scslam
