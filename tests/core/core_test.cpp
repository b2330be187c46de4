// Stamps, files, bytes, threads, trajectories, clouds.
#include <fstream>
#include <numeric>

#include "scslam/core/bytes.h"
#include "scslam/core/cloud.h"
#include "scslam/core/file.h"
#include "scslam/core/stamp.h"
#include "scslam/core/trajectory.h"
#include "support/support.h"

namespace scslam {
namespace {

using test::IsNear;

TEST(Stamp, TextKeepsEveryTick) {
  for (const std::int64_t ns : {0L, 100L, 1317617735123456700L, -1500000000L}) {
    const Stamp stamp = stampFromNanoseconds(ns);
    Stamp back;
    ASSERT_TRUE(parseStamp(formatStamp(stamp), back));
    EXPECT_EQ(back, stamp) << formatStamp(stamp);
  }
  EXPECT_EQ(formatStamp(stampFromNanoseconds(1317617735123456700L)), "1317617735.123456700");
  Stamp stamp;
  EXPECT_TRUE(parseStamp("1.5e+1", stamp));
  EXPECT_EQ(stamp, stampFromSeconds(15));
  for (const char* bad : {"", "abc", "1.2.3", "nan", "inf", "-", "1e99"}) EXPECT_FALSE(parseStamp(bad, stamp)) << bad;
}

TEST(File, ReplacesAtomicallyAndLeavesNoTemporaryFile) {
  const auto folder = test::freshFolder();
  writeFileAtomically(folder / "a.txt", "one");
  writeFileAtomically(folder / "a.txt", "two");
  EXPECT_EQ(readFile(folder / "a.txt"), "two");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
  EXPECT_THROW(writeFileAtomically(folder / "absent" / "a.txt", "x"), Error);
  EXPECT_THROW(readFile(folder / "b.txt"), Error);
  EXPECT_THROW(readFile(folder), Error);
  EXPECT_THROW(readFile(folder / "a.txt", 2), Error);
}

TEST(File, AppendSurvivesReopeningAndCutsWhereTold) {
  const auto folder = test::freshFolder();
  {
    AppendFile file(folder / "j", 0);
    file.append("hello ");
    file.append("world");
    EXPECT_EQ(file.size(), 11u);
  }
  AppendFile file(folder / "j", 6);
  file.append("there");
  EXPECT_EQ(readFile(folder / "j"), "hello there");
}

TEST(Bytes, WhatIsPutIsGotAndLyingCountsAreRefused) {
  ByteWriter writer;
  writer.put(3.5);
  writer.put(std::string("text"));
  writer.put(poseFromYaw(1, {1, 2, 3}));
  writer.put(std::vector<float>{1, 2, 3});
  ByteReader reader(writer.bytes());
  EXPECT_EQ(reader.get<double>(), 3.5);
  std::string text;
  reader.get(text);
  EXPECT_EQ(text, "text");
  Pose T;
  reader.get(T);
  EXPECT_EQ(T.matrix(), poseFromYaw(1, {1, 2, 3}).matrix());
  std::vector<float> values;
  reader.get(values);
  EXPECT_EQ(values, (std::vector<float>{1, 2, 3}));
  EXPECT_TRUE(reader.done());
  ByteWriter lying;
  lying.put(std::uint64_t{1} << 62);
  ByteReader liar(lying.bytes());
  EXPECT_THROW(liar.get(values), Error);
  ByteReader short_reader("abc");
  EXPECT_THROW(short_reader.get<double>(), Error);
}

TEST(ThreadPool, VisitsEveryItemOnceForAnyNumberOfThreads) {
  for (const int threads : {1, 2, 4}) {
    ThreadPool pool(threads);
    for (const std::size_t n : {0u, 1u, 7u, 1000u}) {
      std::vector<int> visits(n, 0);
      for (int round = 0; round < 20; ++round)
        pool.forEachChunk(n, 7, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
          EXPECT_EQ(begin, chunk * 7);
          for (std::size_t i = begin; i < end; ++i) ++visits[i];
        });
      EXPECT_EQ(std::accumulate(visits.begin(), visits.end(), 0), static_cast<int>(20 * n));
    }
  }
}

TEST(ThreadPool, RethrowsTheFailureOfTheFirstChunk) {
  ThreadPool pool(2);
  const auto body = [](std::size_t, std::size_t, std::size_t chunk) {
    if (chunk >= 3) throw std::runtime_error("chunk " + std::to_string(chunk));
  };
  for (int round = 0; round < 20; ++round) {
    try {
      pool.forEachChunk(100, 10, body);
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "chunk 3");
    }
  }
}

TEST(Trajectory, ReadsBothFormsAndGuessesWhich) {
  const auto folder = test::freshFolder();
  const Pose T = retract(poseFromYaw(1, {1, 2, 3}), (Vector6d() << 0, 0, 0, 0.1, 0.2, 0.3).finished());
  writeFileAtomically(folder / "a.tum",
                      "# comment\n\n" + formatTum({{stampFromSeconds(1), T}, {stampFromSeconds(2), Pose::Identity()}}));
  const Trajectory tum = readTrajectory(folder / "a.tum");
  ASSERT_EQ(tum.poses.size(), 2u);
  EXPECT_TRUE(tum.timed);
  EXPECT_THAT(tum.poses[0].T, IsNear(T, 1e-12, 1e-6));
  EXPECT_EQ(tum.poses[0].stamp, stampFromSeconds(1));
  writeFileAtomically(folder / "a.txt", formatKitti({T, T}));
  EXPECT_FALSE(readTrajectory(folder / "a.txt").timed);
  EXPECT_THAT(readTrajectory(folder / "a.txt").poses[1].T, IsNear(T, 1e-12, 1e-6));
}

TEST(Trajectory, DamagedLinesAreNamed) {
  const auto folder = test::freshFolder();
  const auto complaint = [&](const std::string& text) -> std::string {
    writeFileAtomically(folder / "t.txt", text);
    try {
      readTrajectory(folder / "t.txt");
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(complaint("1 0 0 0 0 0 0 1\n0.5 0 0 0 0 0 0 1\n"), testing::HasSubstr("t.txt:2"));
  EXPECT_THAT(complaint("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0\n"), testing::HasSubstr("t.txt:2: 7 columns"));
  EXPECT_THAT(complaint("1 0 0 0 0 0 0 3\n"), testing::HasSubstr("quaternion"));
  EXPECT_THAT(complaint("1 0 0 nan 0 0 0 1\n"), testing::HasSubstr("'nan' is not a finite number"));
  EXPECT_THAT(complaint("1 0 0 0 0 1 0 0 0 0 -1 0\n"), testing::HasSubstr("not a rotation"));
  EXPECT_THAT(complaint("1 2 3\n"), testing::HasSubstr("3 columns"));
  EXPECT_THAT(complaint("\n# nothing\n"), testing::HasSubstr("no poses"));
}

TEST(Trajectory, InterpolatesInsideAndIsSilentOutside) {
  Trajectory trajectory;
  trajectory.poses = {{stampFromSeconds(0), Pose::Identity()},
                      {stampFromSeconds(1), poseFromYaw(0.2, {2, 0, 0})},
                      {stampFromSeconds(20), Pose::Identity()}};
  EXPECT_THAT(*trajectory.at(stampFromSeconds(0.5)), IsNear(poseFromYaw(0.1, {1, 0, 0}), 1e-9, 1e-6));
  EXPECT_TRUE(trajectory.at(stampFromSeconds(-0.005)).has_value());
  EXPECT_FALSE(trajectory.at(stampFromSeconds(-0.5)).has_value());
  EXPECT_FALSE(trajectory.at(stampFromSeconds(10)).has_value()) << "inside a gap of 19 s";
  EXPECT_FALSE(trajectory.at(stampFromSeconds(21)).has_value());
}

TEST(Cloud, FilterAndTransformKeepFieldsTogether) {
  Cloud cloud;
  for (int i = 0; i < 5; ++i)
    cloud.push(static_cast<float>(i), 0, 0), cloud.ring.push_back(static_cast<std::uint16_t>(i));
  cloud.y[1] = std::numeric_limits<float>::quiet_NaN();
  cloud.z[3] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(dropNonFinite(cloud), 2u);
  EXPECT_EQ(cloud.ring, (std::vector<std::uint16_t>{0, 2, 4}));
  transformInPlace(cloud, poseFromYaw(M_PI / 2, {10, 0, 1}));
  EXPECT_NEAR(cloud.x[2], 10, 1e-5);
  EXPECT_NEAR(cloud.y[2], 4, 1e-5);
  EXPECT_NEAR(cloud.z[2], 1, 1e-6);
}

}  // namespace
}  // namespace scslam
