#include "support/support.h"

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <random>
#include <sstream>

namespace scslam::test {

namespace fs = std::filesystem;

fs::path freshFolder() {
  const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
  std::string name = std::string(info->test_suite_name()) + "." + info->name();
  for (char& c : name)
    if (c == '/') c = '_';
  const fs::path folder = fs::path(SCSLAM_TEST_TMP) / name;
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

std::optional<fs::path> sharedData(const std::string& name) {
  const char* from_environment = std::getenv("SCSLAM_DATA");
  const fs::path root =
      from_environment != nullptr ? fs::path(from_environment) : fs::path(SCSLAM_SOURCE_DIR) / "../shared/data";
  const fs::path path = root / name;
  return fs::exists(path) ? std::optional(path) : std::nullopt;
}

PluginContext context(int threads) {
  static Log log(mrpt::system::LVL_ERROR);
  static ThreadPool one(1), two(2), four(4);
  return {threads == 1 ? one : threads == 2 ? two : four, log};
}

RunResult runScslam(const std::string& arguments) {
  const fs::path err_file = fs::path(SCSLAM_TEST_TMP) / ("stderr." + std::to_string(::getpid()));
  fs::create_directories(SCSLAM_TEST_TMP);
  const std::string command = std::string(SCSLAM_BINARY) + " " + arguments + " 2>" + err_file.string();
  RunResult result;
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("popen failed");
  char buffer[4096];
  while (const std::size_t n = std::fread(buffer, 1, sizeof buffer, pipe)) result.out.append(buffer, n);
  const int status = ::pclose(pipe);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  std::stringstream err;
  err << std::ifstream(err_file).rdbuf();
  result.err = err.str();
  fs::remove(err_file);
  return result;
}

namespace {

struct Plane {
  Eigen::Vector3d origin, u, v;  // the patch origin + a u + b v, 0 <= a, b <= 1
};

void addBox(std::vector<Plane>& planes, Eigen::Vector3d lo, Eigen::Vector3d size) {
  const Eigen::Vector3d x(size.x(), 0, 0), y(0, size.y(), 0), z(0, 0, size.z());
  planes.insert(planes.end(), {{lo, x, y}, {lo + z, x, y}, {lo, x, z}, {lo + y, x, z}, {lo, y, z}, {lo + x, y, z}});
}

}  // namespace

Cloud aRoom(std::size_t points, std::uint32_t seed, double noise_m) {
  std::vector<Plane> planes;
  addBox(planes, {-10, -6, 0}, {20, 12, 4});
  addBox(planes, {4, 2, 0}, {2, 1.5, 2.2});
  addBox(planes, {-7, -4.5, 0}, {1, 3, 1.2});
  addBox(planes, {-3, 4, 0}, {1.2, 1.2, 3});
  std::vector<double> area;
  double total = 0;
  for (const auto& plane : planes) area.push_back(total += plane.u.norm() * plane.v.norm());
  std::mt19937 random(seed);
  const auto uniform = [&random] { return static_cast<double>(random()) / 4294967296.0; };
  Cloud cloud;
  for (std::size_t i = 0; i < points; ++i) {
    const double pick = uniform() * total;
    std::size_t k = 0;
    while (area[k] < pick) ++k;
    const Plane& plane = planes[k];
    const double a = uniform(), b = uniform();
    double noise = 0;  // sum of uniforms: near enough to a Gaussian, the same on every machine
    for (int j = 0; j < 12; ++j) noise += uniform() - 0.5;
    const Eigen::Vector3d p =
        plane.origin + a * plane.u + b * plane.v + noise_m * noise * plane.u.cross(plane.v).normalized();
    cloud.push(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
  }
  return cloud;
}

}  // namespace scslam::test
