#include "scslam/session/session_writer.h"

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/pcd.h"
#include "scslam/graph/g2o.h"
#include "scslam/session/cloud_store.h"
#include "scslam/session/layout.h"
#include "scslam/session/session.h"
#include "session/folder_bytes.h"
#include "session/made_up_session.h"
#include "session/memory_folder.h"
#include "support/support.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

std::string messageOf(const std::function<void()>& action, ExitCode code) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(static_cast<int>(error.code()), static_cast<int>(code)) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return {};
}

fs::path written(const std::string& name = "s") {
  const fs::path folder = memoryFolder() / name;
  const MadeUpSession session;
  session.tellAll(*SessionWriter::create(folder, session.info, false));
  return folder;
}

TEST(SessionWriter, WritesTheClassicLayoutAndOurFilesAndNothingElse) {
  auto names = namesIn(bytesOf(written()));
  std::erase_if(names, [](const std::string& name) { return name.starts_with("Scans/") || name.starts_with("SCDs/"); });
  EXPECT_THAT(names, ::testing::ElementsAre("config.yaml", "journal.bin", "loops.csv", "metrics.json", "odom_poses.txt",
                                            "odometry.tum", "optimized_poses.txt", "run.log", "session.yaml",
                                            "singlesession_posegraph.g2o", "times.txt", "trajectory.tum"));
}

TEST(SessionWriter, KeepsFixesAndTheLastVerdictOnEachLoop) {
  const fs::path folder = memoryFolder() / "s";
  const MadeUpSession made;
  GnssRecord record;
  record.keyframe = 2;
  record.fix = {stampFromSeconds(1e9 + 0.65),          48.123456789, 11.5, 512.25,
                Eigen::Vector3d(1, 4, 9).asDiagonal(), {1, 2, 3}};
  record.antenna_in_keyframe_m = {1.5, 2, 3};
  {
    const auto writer = SessionWriter::create(folder, made.info, false);
    std::size_t events = 0;
    made.tellAll(*writer, [&] {
      if (++events == 20) writer->addGnss(record);
    });
    writer->judgeLoop({0, false, "taken back"});
    writer->judgeLoop({1, true, "accepted"});
  }
  const Session session = Session::open(folder);
  ASSERT_GE(session.loops().size(), 2u);
  EXPECT_FALSE(session.loops()[0].accepted);
  EXPECT_EQ(session.loops()[0].reason, "taken back");
  EXPECT_TRUE(session.loops()[1].accepted);
  ASSERT_EQ(session.gnss().size(), 1u);
  EXPECT_EQ(session.gnss()[0].keyframe, 2u);
  EXPECT_EQ(session.gnss()[0].fix.stamp, record.fix.stamp);
  EXPECT_EQ(session.gnss()[0].fix.latitude_deg, 48.123456789);
  EXPECT_EQ(session.gnss()[0].fix.covariance_m2, record.fix.covariance_m2);
  EXPECT_EQ(session.gnss()[0].antenna_in_keyframe_m, record.antenna_in_keyframe_m);
  EXPECT_EQ(readFile(folder / "gnss.csv"),
            "keyframe,time_s,latitude_deg,longitude_deg,height_m,sigma_east_m,sigma_north_m,sigma_up_m,"
            "antenna_x_m,antenna_y_m,antenna_z_m\n"
            "2,1000000000.650000000,48.1234567890,11.5000000000,512.2500,1,2,3,1.5,2,3\n");
}

TEST(SessionWriter, SessionReadsBackBitForBit) {
  const fs::path folder = written();
  const MadeUpSession made;
  const Session session = Session::open(folder);
  EXPECT_TRUE(session.complete());
  EXPECT_FALSE(session.classic());
  EXPECT_EQ(session.info().config_yaml, made.info.config_yaml);
  EXPECT_EQ(session.info().sensor_label, made.info.sensor_label);
  EXPECT_EQ(session.info().T_base_sensor.matrix(), made.info.T_base_sensor.matrix());
  ASSERT_EQ(session.scans().size(), made.scan_count);
  ASSERT_EQ(session.keyframes().size(), 8u);
  EXPECT_EQ(session.scans()[5].T_odom_base.matrix(), made.odometryAt(5).matrix());
  EXPECT_EQ(session.keyframes()[3].stamp, session.scans()[9].stamp);
  EXPECT_EQ(session.keyframes()[3].step_covariance, Matrix6d(1e-4 * Matrix6d::Identity()));
  Vector6d passing;
  passing << 1e-4, 2e-4, 3e-4, 4e-6, 5e-6, 18e-6;
  EXPECT_EQ(session.keyframes()[3].step_passing, passing);
  for (KeyframeId k = 0; k < 8; ++k) {
    EXPECT_EQ(session.cloud(k).x, made.cloudOf(k).x);
    EXPECT_EQ(session.cloud(k).intensity, made.cloudOf(k).intensity);
    EXPECT_EQ(session.descriptor(k), made.descriptorOf(k));
  }
  ASSERT_EQ(session.loops().size(), 3u);
  EXPECT_EQ(session.loops()[1].reason, "overlap 0.1 < 0.3, too \"little\"");
  EXPECT_EQ(session.graph().factors.size(), 7u + 2u);
}

TEST(SessionWriter, TextFilesHoldSensorPosesAndTheGraph) {
  const fs::path folder = written();
  const Session session = Session::open(folder);
  const Pose S = session.info().T_base_sensor;
  const Trajectory optimised = readTrajectory(folder / "optimized_poses.txt");
  const Trajectory odometry = readTrajectory(folder / "odom_poses.txt");
  const PoseGraph graph = readG2o(folder / "singlesession_posegraph.g2o").graph;
  ASSERT_EQ(optimised.poses.size(), 8u);
  ASSERT_EQ(graph.poses.size(), 8u);
  ASSERT_EQ(graph.factors.size(), 9u);
  for (std::size_t k = 0; k < 8; ++k) {
    EXPECT_THAT(optimised.poses[k].T, IsNear(session.poses()[k] * S, 1e-12, 1e-9));
    EXPECT_THAT(odometry.poses[k].T, IsNear(session.keyframes()[k].T_odom_base * S, 1e-12, 1e-9));
    EXPECT_THAT(graph.poses[k], IsNear(session.poses()[k] * S, 1e-12, 1e-9));
  }
  const Factor& loop = graph.factors.back();
  EXPECT_THAT(loop.T_i_j, IsNear(S.inverse() * session.loops().back().T_match_query * S, 1e-9, 1e-7));
}

TEST(SessionWriter, SensorFrameKeepsTheChi2OfAFactor) {
  const MadeUpSession made;
  PoseGraph graph;
  graph.poses = {made.odometryAt(0), made.odometryAt(4)};
  Vector6d error;
  error << 1e-4, -2e-4, 3e-4, 1e-4, 2e-4, -1e-4;
  Matrix6d A;
  for (int i = 0; i < 36; ++i) A(i / 6, i % 6) = std::sin(i * 1.7);
  graph.factors.push_back(
      {FactorKind::kLoop, 0, 1, retract(graph.poses[0].inverse() * graph.poses[1], error), A * A.transpose()});
  const auto chi2 = [](const PoseGraph& g) {
    const Vector6d r = local(g.factors[0].T_i_j, g.poses[0].inverse() * g.poses[1]);
    return r.dot(g.factors[0].information * r);
  };
  const double before = chi2(graph);
  EXPECT_NEAR(chi2(graphOfSensor(graph, made.info.T_base_sensor)), before, 1e-3 * before);
}

TEST(SessionWriter, TrajectoryOfEveryScanFollowsItsKeyframe) {
  const Session session = Session::open(written());
  const auto trajectory = session.trajectory();
  ASSERT_EQ(trajectory.size(), 24u);
  for (std::size_t k = 0; k < 8; ++k) {
    EXPECT_THAT(trajectory[3 * k].T, IsNear(session.poses()[k], 1e-9, 1e-7));
    const Pose step = session.scans()[3 * k].T_odom_base.inverse() * session.scans()[3 * k + 2].T_odom_base;
    EXPECT_THAT(trajectory[3 * k + 2].T, IsNear(session.poses()[k] * step, 1e-9, 1e-7));
  }
}

TEST(SessionWriter, FormsAreTheClassicOnes) {
  const fs::path folder = written();
  const auto files = bytesOf(folder);
  EXPECT_TRUE(files.at("Scans/000003.pcd")
                  .starts_with("# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z intensity\n"
                               "SIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 23\nHEIGHT 1\n"
                               "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 23\nDATA binary\n"));
  EXPECT_EQ(files.at("SCDs/000001.scd"), "0 0.25 0.5 0.75\n1 1.25 1.5 1.75\n2 2.25 2.5 2.75");
  EXPECT_TRUE(files.at("times.txt").starts_with("1000000000\n1000000000.3\n"));
  EXPECT_TRUE(files.at("trajectory.tum").starts_with("1000000000.000000000 "));
  EXPECT_THAT(files.at("loops.csv"), HasSubstr(",refused,\"overlap 0.1 < 0.3, too \"\"little\"\"\"\n"));
  EXPECT_THAT(files.at("session.yaml"), AllOf(HasSubstr("version: 1\nstate: complete\n"), HasSubstr("keyframes: 8\n")));
}

TEST(SessionWriter, ExistingSessionIsReplacedOnlyWhenAsked) {
  const fs::path folder = written();
  const MadeUpSession made;
  const auto message = messageOf([&] { SessionWriter::create(folder, made.info, false); }, ExitCode::kUsage);
  EXPECT_THAT(message, AllOf(HasSubstr("-w"), HasSubstr("--resume"), HasSubstr(folder.string())));
  writeFileAtomically(folder / "my notes.txt", "keep me");
  const auto before = bytesOf(folder);
  made.tellAll(*SessionWriter::create(folder, made.info, true));
  EXPECT_EQ(bytesOf(folder), before);  // the same session again, and the user's own file
}

TEST(SessionWriter, FolderThatIsNoSessionIsNeverTouched) {
  const fs::path folder = memoryFolder();
  writeFileAtomically(folder / "thesis.tex", "years of work");
  fs::create_directories(folder / "Scans");
  writeFileAtomically(folder / "Scans/000000.pcd", "a classic scan");
  const auto before = bytesOf(folder);
  for (const bool overwrite : {false, true})
    messageOf([&] { SessionWriter::create(folder, MadeUpSession().info, overwrite); }, ExitCode::kUsage);
  EXPECT_EQ(bytesOf(folder), before);
}

TEST(SessionWriter, EmptyFolderAndMissingParentsAreFine) {
  const MadeUpSession made;
  EXPECT_NO_THROW(made.tellAll(*SessionWriter::create(memoryFolder(), made.info, false)));
  EXPECT_NO_THROW(made.tellAll(*SessionWriter::create(memoryFolder() / "a/b/c", made.info, false)));
}

TEST(SessionWriter, NeverRemovesItsOwnInput) {
  const fs::path folder = written();
  MadeUpSession made;
  const auto before = bytesOf(folder);
  for (const fs::path& input : {folder, folder / "Scans"}) {
    made.info.input = input.string();
    messageOf([&] { SessionWriter::create(folder, made.info, true); }, ExitCode::kUsage);
  }
  EXPECT_EQ(bytesOf(folder), before);
}

TEST(SessionWriter, SecondWriterIsKeptOff) {
  const fs::path folder = memoryFolder() / "s";
  const MadeUpSession made;
  const auto writer = SessionWriter::create(folder, made.info, false);
  EXPECT_THAT(messageOf([&] { SessionWriter::create(folder, made.info, true); }, ExitCode::kUsage),
              HasSubstr("another scslam"));
}

TEST(SessionWriter, EmptySessionIsASession) {
  const fs::path folder = memoryFolder() / "s";
  SessionWriter::create(folder, MadeUpSession().info, false)->finish({});
  const Session session = Session::open(folder);
  EXPECT_TRUE(session.complete());
  EXPECT_TRUE(session.trajectory().empty());
}

TEST(CloudStore, GivesTheSameCloudsWhateverItsBudget) {
  const fs::path folder = written();
  CloudStore small(folder, 1), large(folder, 1 << 20);
  for (const KeyframeId k : {0u, 1u, 0u, 7u, 1u}) EXPECT_EQ(small.get(k)->x, large.get(k)->x);
  EXPECT_EQ(small.reads(), 5u);
  EXPECT_EQ(large.reads(), 3u);
  EXPECT_LE(small.cachedBytes(), 21u * 16u);
  EXPECT_THROW(large.get(8), Error);
}

TEST(Session, OpensAClassicFolder) {
  SCSLAM_NEEDS_DATA(folder, "scaloam_session_Seosan01");
  const Session session = Session::open(folder);
  EXPECT_TRUE(session.classic());
  ASSERT_EQ(session.keyframes().size(), 2878u);
  EXPECT_EQ(session.cloud(0).size(), 62082u);
  EXPECT_TRUE(session.hasCloud(20));
  EXPECT_FALSE(session.hasCloud(21));
  EXPECT_EQ(formatStamp(session.keyframes()[0].stamp), "1624254615.786958000");
}

TEST(Session, ClassicLoopsAreTheEdgesThatSkip) {
  const fs::path folder = written();
  const Session ours = Session::open(folder);
  for (const char* name : {"session.yaml", "journal.bin"}) fs::remove(folder / name);
  const Session classic = Session::open(folder);
  EXPECT_TRUE(classic.classic());
  ASSERT_EQ(classic.loops().size(), 2u);
  EXPECT_EQ(classic.loops()[0].query, 5u);
  EXPECT_EQ(classic.loops()[0].match, 0u);
  EXPECT_THAT(classic.poses()[7], IsNear(ours.poses()[7] * ours.info().T_base_sensor, 1e-9, 1e-7));
}

TEST(Session, SaysWhatAFolderLacks) {
  const fs::path folder = memoryFolder();
  EXPECT_THAT(messageOf([&] { Session::open(folder); }, ExitCode::kInput), HasSubstr("is no session"));
  EXPECT_THAT(messageOf([&] { Session::open(folder / "nowhere"); }, ExitCode::kInput), HasSubstr("does not exist"));
}

}  // namespace
}  // namespace scslam::test
