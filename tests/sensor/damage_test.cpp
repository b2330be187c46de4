// Rawlogs cut and flipped anywhere: an error that names file and byte, or fewer scans; never a crash, a hang or memory
// beyond the limit.
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>
#include <mrpt/system/filesystem.h>
#include <sys/resource.h>

#include <cstdint>
#include <random>

#include "fixtures.h"
#include "scslam/sensor/memory_limit.h"

namespace scslam {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kLimitsWork = false;
#else
constexpr bool kLimitsWork = true;
#endif

long peakMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss / 1024;
}

/// All classes with sizes in them.
std::vector<mrpt::serialization::CSerializable::Ptr> mixedObjects() {
  auto objects = test::rawlogObjects();
  auto laser = mrpt::obs::CObservation2DRangeScan::Create();
  const std::vector<float> ranges(181, 5.F);
  const std::vector<char> valid(181, 1);
  laser->loadFromVectors(ranges.size(), ranges.data(), valid.data());
  auto velodyne = mrpt::obs::CObservationVelodyneScan::Create();
  velodyne->timestamp = test::fixtureStamp(1);
  velodyne->sensorLabel = "lidar";
  for (int i = 0; i < 300; ++i) {
    velodyne->point_cloud.x.push_back(1), velodyne->point_cloud.y.push_back(2), velodyne->point_cloud.z.push_back(3);
    velodyne->point_cloud.intensity.push_back(4);
  }
  auto image = mrpt::obs::CObservationRotatingScan::Create();
  image->rowCount = 16, image->columnCount = 50;
  image->rangeResolution = 0.002;
  image->rangeImage.setZero(16, 50);
  image->intensityImage.setZero(16, 50);
  objects.insert(objects.begin() + 2, {laser, velodyne, image});
  return objects;
}

/// Reads to the end. @return the message, empty after a clean end.
std::string readThrough(const fs::path& file, std::size_t& scans) {
  scans = 0;
  return test::messageOf([&] {
    const auto source = test::openQuietly(file).source;
    while (source->next()) ++scans;
  });
}

std::vector<std::pair<const char*, std::string>> goodFiles(const fs::path& folder) {
  test::writeRawlog(folder / "plain.rawlog", mixedObjects(), 0);
  test::writeRawlog(folder / "packed.rawlog", mixedObjects(), 1);
  std::vector<std::pair<const char*, std::string>> files = {{"plain", test::readBytes(folder / "plain.rawlog")},
                                                            {"packed", test::readBytes(folder / "packed.rawlog")}};
  const fs::path shipped = fs::path(mrpt::system::getShareMRPTDir()) / "datasets" / "test_velodyne_VLP16.rawlog";
  if (fs::is_regular_file(shipped)) files.emplace_back("vlp16", test::readBytes(shipped));
  return files;
}

TEST(DamagedRawlog, CutAnywhereGivesTheScansBeforeAndThenTheByte) {
  const auto folder = test::freshFolder();
  for (const auto& [name, good] : goodFiles(folder)) {
    std::size_t clean_ends = 0;
    for (std::size_t k = 0; k < 60; ++k) {
      const std::size_t cut = 1 + k * (good.size() - 1) / 60;
      const auto file = folder / "cut.rawlog";
      test::writeBytes(file, good.substr(0, cut));
      std::size_t scans = 0;
      const std::string message = readThrough(file, scans);
      EXPECT_LE(scans, test::kFixtureScans);
      if (message.empty())
        ++clean_ends;  // a plain file cut between two objects looks whole to anybody
      else
        EXPECT_THAT(message, HasSubstr("cut.rawlog")) << name << " cut at " << cut;
    }
    EXPECT_LE(clean_ends, std::string(name) == "plain" ? 3U : 0U) << "a compressed file has a checksum at its end";
  }
}

TEST(DamagedRawlog, EveryByteOfACompressedTrailerIsMissed) {
  const auto folder = test::freshFolder();
  const std::string good = goodFiles(folder)[1].second;
  for (std::size_t missing = 1; missing <= 8; ++missing) {
    test::writeBytes(folder / "cut.rawlog", good.substr(0, good.size() - missing));
    std::size_t scans = 0;
    EXPECT_THAT(readThrough(folder / "cut.rawlog", scans), HasSubstr("ends too early")) << missing;
    EXPECT_EQ(scans, test::kFixtureScans) << "all of them came before the damage";
  }
}

TEST(DamagedRawlog, FlippedBitsNeverCrashNorEatMemory) {
  if (!kLimitsWork) GTEST_SKIP() << "sanitizers map too much for a memory limit";
  const auto folder = test::freshFolder();
  const auto files = goodFiles(folder);
  const long before = peakMegabytes();
  std::mt19937 random(7);
  for (const auto& [name, good] : files)
    for (int k = 0; k < 200; ++k) {
      std::string bad = good;
      const std::size_t bit = random() % (8 * std::min<std::size_t>(good.size(), 20'000));
      bad[bit / 8] = static_cast<char>(bad[bit / 8] ^ (1 << (bit % 8)));
      test::writeBytes(folder / "bad.rawlog", bad);
      std::size_t scans = 0;
      const std::string message = readThrough(folder / "bad.rawlog", scans);
      ASSERT_TRUE(message.empty() || message.find("bad.rawlog") != std::string::npos) << name << " bit " << bit;
      ASSERT_LE(scans, test::kFixtureScans + 1);
    }
  EXPECT_LT(peakMegabytes() - before, 1200) << "a lying size may cost at most the limit, for a moment";
}

TEST(DamagedRawlog, LyingCountsAreRefusedBeforeMemoryIsTaken) {
  const auto folder = test::freshFolder();
  auto laser = mrpt::obs::CObservation2DRangeScan::Create();
  const std::vector<float> ranges(1234567, 5.F);
  const std::vector<char> valid(ranges.size(), 1);
  laser->loadFromVectors(ranges.size(), ranges.data(), valid.data());
  Cloud cloud;
  cloud.resize(1234567);
  cloud.intensity.resize(cloud.size());
  const auto lie = [&](const mrpt::serialization::CSerializable::Ptr& object) {
    test::writeRawlog(folder / "good.rawlog", {object}, 0);
    std::string bytes = test::readBytes(folder / "good.rawlog");
    const std::uint32_t honest = 1234567, lying = 4'000'000'000;
    const std::size_t at = bytes.find(std::string(reinterpret_cast<const char*>(&honest), 4));
    bytes.replace(at, 4, reinterpret_cast<const char*>(&lying), 4);
    test::writeBytes(folder / "bad.rawlog", bytes);
    std::size_t scans = 0;
    return readThrough(folder / "bad.rawlog", scans);
  };
  EXPECT_THAT(lie(laser), HasSubstr("a CObservation2DRangeScan states 4000000000 elements"));
  EXPECT_THAT(lie(test::pointCloudObservation(cloud, test::fixtureStamp(0))),
              HasSubstr("a CPointsMapXYZI states 4000000000 elements"));
}

TEST(DamagedRawlog, AnImageThatCannotBeIsRefused) {
  const auto folder = test::freshFolder();
  auto image = mrpt::obs::CObservationRotatingScan::Create();
  image->rowCount = 16, image->columnCount = 50;
  image->rangeImage.setZero(16, 50);
  test::writeRawlog(folder / "good.rawlog", {image}, 0);
  std::string bytes = test::readBytes(folder / "good.rawlog");
  const std::string honest("\x32\0\x10\0", 4);
  ASSERT_NE(bytes.rfind(honest), std::string::npos);
  bytes.replace(bytes.rfind(honest), 4, "\xff\xff\xff\xff");
  test::writeBytes(folder / "bad.rawlog", bytes);
  std::size_t scans = 0;
  EXPECT_THAT(readThrough(folder / "bad.rawlog", scans), HasSubstr("an image of 65535 x 65535 is stated"));
}

TEST(MemoryLimit, BoundsAllocationsAndReturnsTheFormerLimit) {
  if (!kLimitsWork) GTEST_SKIP() << "sanitizers map too much for a memory limit";
  rlimit before{}, after{};
  getrlimit(RLIMIT_AS, &before);
  {
    const MemoryLimit outer(std::size_t{256} << 20);
    {
      const MemoryLimit looser(std::size_t{1} << 30);
      EXPECT_NO_THROW(std::vector<char>(std::size_t{512} << 20).at(5));
    }
    EXPECT_THROW(std::vector<char>(std::size_t{8} << 30).at(5), std::bad_alloc);
  }
  getrlimit(RLIMIT_AS, &after);
  EXPECT_EQ(before.rlim_cur, after.rlim_cur);
}

}  // namespace
}  // namespace scslam
