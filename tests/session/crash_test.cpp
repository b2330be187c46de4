// What a kill, a full disk or damage leaves: always a session that opens, and one that resumes to the same bytes.
#include <sys/resource.h>

#include <csignal>

#include "scslam/core/error.h"
#include "scslam/session/journal.h"
#include "scslam/session/layout.h"
#include "scslam/session/session.h"
#include "session/folder_bytes.h"
#include "session/made_up_session.h"
#include "session/memory_folder.h"
#include "support/support.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

std::map<std::string, std::string> undisturbed() {
  const fs::path folder = memoryFolder() / "undisturbed";
  const MadeUpSession made;
  made.tellAll(*SessionWriter::create(folder, made.info, false));
  return bytesOf(folder);
}

/// Resumes what lies in `folder` and goes on to the end, as a pipeline would.
void resumeAndFinish(const fs::path& folder) {
  const MadeUpSession made;
  RecoveredSession recovered;
  const auto writer = SessionWriter::resume(folder, made.info, recovered);
  const std::size_t next = recovered.pipeline_state.empty() ? 0 : std::stoul(recovered.pipeline_state);
  ASSERT_EQ(recovered.scans.size(), next);
  ASSERT_EQ(recovered.descriptors.size(), recovered.keyframes.size());
  for (std::size_t k = 0; k < recovered.descriptors.size(); ++k)
    ASSERT_EQ(recovered.descriptors[k], made.descriptorOf(k));
  made.tell(*writer, next, recovered.keyframes, recovered.T_map_base, recovered.loops);
}

/// Copies the folder after each event of a run.
std::vector<fs::path> snapshots(const fs::path& root) {
  const MadeUpSession made;
  std::vector<fs::path> copies;
  const auto writer = SessionWriter::create(root / "live", made.info, false);
  made.tellAll(*writer, [&] {
    copies.push_back(root / ("copy" + std::to_string(copies.size())));
    fs::copy(root / "live", copies.back(), fs::copy_options::recursive);
  });
  return copies;
}

TEST(Crash, KilledAfterAnyEventTheSessionOpensWithEverythingToldSoFar) {
  std::size_t scans = 0, keyframes = 0;
  for (const fs::path& copy : snapshots(memoryFolder())) {
    const Session session = Session::open(copy);
    EXPECT_FALSE(session.complete());
    EXPECT_GE(session.scans().size(), scans);
    EXPECT_GE(session.keyframes().size(), keyframes);
    scans = session.scans().size();
    keyframes = session.keyframes().size();
    for (KeyframeId k = 0; k < keyframes; ++k) EXPECT_EQ(session.cloud(k).size(), 20u + k);
  }
  EXPECT_EQ(scans, 24u);
}

TEST(Crash, ResumedAfterAnyEventTheRunEndsInTheSameBytes) {
  const auto expected = undisturbed();
  for (const fs::path& copy : snapshots(memoryFolder())) {
    resumeAndFinish(copy);
    const auto bytes = bytesOf(copy);
    ASSERT_EQ(namesIn(bytes), namesIn(expected)) << copy;
    for (const auto& [name, content] : expected) ASSERT_EQ(bytes.at(name), content) << copy << ": " << name;
  }
}

TEST(Crash, HalfWrittenFilesDoNotDisturbAResume) {
  const auto expected = undisturbed();
  const fs::path copy = snapshots(memoryFolder())[40];
  for (const char* name : {"Scans/000017.pcd", "Scans/000002.pcd.tmp", "SCDs/000017.scd", "times.txt.tmp"})
    writeFileAtomically(copy / name, "half");
  AppendFile(copy / "journal.bin", fs::file_size(copy / "journal.bin")).append("torn record");
  resumeAndFinish(copy);
  EXPECT_EQ(bytesOf(copy), expected);
}

TEST(Crash, JournalCutAtAnyByteIsAPrefix) {
  const fs::path copy = snapshots(memoryFolder()).back();
  const std::string journal = readFile(copy / "journal.bin");
  const JournalContents whole = readJournal(copy / "journal.bin");
  std::size_t scans = 0;
  for (std::size_t length = 0; length <= journal.size(); ++length) {
    AppendFile(copy / "cut", 0).append(journal.substr(0, length));
    fs::rename(copy / "cut", copy / "journal.bin");
    const Session session = Session::open(copy);
    ASSERT_GE(session.scans().size(), scans);
    scans = session.scans().size();
    ASSERT_EQ(session.poses().size(), session.keyframes().size());
    for (std::size_t i = 0; i < scans; ++i)
      ASSERT_EQ(session.scans()[i].T_odom_base.matrix(), whole.scans[i].T_odom_base.matrix());
    ASSERT_EQ(session.trajectory().size(), scans);
  }
  EXPECT_EQ(scans, whole.scans.size());
}

TEST(Crash, FlippedByteEndsTheJournalThereAndNeverCrashes) {
  const fs::path copy = snapshots(memoryFolder()).back();
  const std::string journal = readFile(copy / "journal.bin");
  for (std::size_t i = 12; i < journal.size(); i += 11) {
    std::string damaged = journal;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x40);
    AppendFile(copy / "journal.bin", 0).append(damaged);
    const JournalContents contents = readJournal(copy / "journal.bin");
    ASSERT_FALSE(contents.problem.empty()) << "byte " << i;
    ASSERT_LE(contents.valid_bytes, i);
  }
}

TEST(Crash, DamagedCompleteSessionIsReportedNotShortened) {
  const fs::path folder = freshFolder() / "s";
  const MadeUpSession made;
  made.tellAll(*SessionWriter::create(folder, made.info, false));
  fs::resize_file(folder / "journal.bin", fs::file_size(folder / "journal.bin") - 3);
  try {
    Session::open(folder);
    FAIL() << "opened";
  } catch (const Error& error) {
    EXPECT_EQ(static_cast<int>(error.code()), 3);
    EXPECT_THAT(error.what(), HasSubstr("scslam doctor"));
  }
}

TEST(Crash, ResumeRefusesAnotherInputConfigurationOrACompleteSession) {
  const fs::path root = memoryFolder();
  const fs::path copy = snapshots(root)[20];
  RecoveredSession recovered;
  const auto refusal = [&](const fs::path& folder, const SessionInfo& info) -> std::string {
    try {
      SessionWriter::resume(folder, info, recovered);
    } catch (const Error& error) {
      EXPECT_EQ(static_cast<int>(error.code()), 2);
      return error.what();
    }
    return "";
  };
  MadeUpSession made;
  EXPECT_THAT(refusal(root / "live", made.info), HasSubstr("complete"));
  EXPECT_THAT(refusal(root / "nowhere", made.info), HasSubstr("no session to resume"));
  made.info.config_yaml = "voxel_m: 0.7\nname: \"a: b\"\n";
  EXPECT_THAT(refusal(copy, made.info), HasSubstr("the session has 'voxel_m: 0.5', now 'voxel_m: 0.7'"));
  made = {};
  made.info.input_digest = "other";
  EXPECT_THAT(refusal(copy, made.info), HasSubstr("another input"));
}

/// Lets files of this process grow no further than `bytes`; write() then fails with EFBIG as a full disk does.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(std::size_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() { ::setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

TEST(Crash, FullDiskIsOneErrorAndTheSessionResumes) {
  const auto expected = undisturbed();
  const MadeUpSession made;
  const std::size_t largest = expected.at("journal.bin").size();
  int failures = 0;
  for (std::size_t limit = 700; limit < largest; limit += 509) {
    const fs::path folder = memoryFolder() / "s";
    std::string message;
    try {
      const auto writer = SessionWriter::create(folder, made.info, false);
      const FileSizeLimit full(limit);
      made.tellAll(*writer);
    } catch (const Error& error) {
      message = error.what();
    }
    ASSERT_THAT(message, HasSubstr("cannot write " + folder.string()));
    ++failures;
    ASSERT_NO_THROW(Session::open(folder));
    ASSERT_NO_FATAL_FAILURE(resumeAndFinish(folder));
    ASSERT_EQ(bytesOf(folder), expected) << limit;
  }
  EXPECT_GT(failures, 5);
}

TEST(Crash, AfterAFailedWriteEveryCallRepeatsThatError) {
  const fs::path folder = memoryFolder() / "s";
  const MadeUpSession made;
  const auto writer = SessionWriter::create(folder, made.info, false);
  std::string message;
  try {
    const FileSizeLimit full(900);
    made.tellAll(*writer);
  } catch (const Error& error) {
    message = error.what();
  }
  PoseGraph three_poses;
  three_poses.poses.resize(3, Pose::Identity());
  for (const auto& call :
       std::vector<std::function<void()>>{[&] { writer->addScan({}); }, [&] { writer->finish(three_poses); }}) {
    try {
      call();
      FAIL() << "no error";
    } catch (const Error& error) {
      EXPECT_EQ(error.what(), message);
    }
  }
}

TEST(Crash, PosesThatWereNotRecordedAreChainedByOdometry) {
  const fs::path file = freshFolder() / "journal.bin";
  const MadeUpSession made;
  Journal journal(file, 0);
  std::vector<Pose> poses;
  for (KeyframeId k = 0; k < 3; ++k) {
    Keyframe keyframe;
    keyframe.id = k;
    keyframe.T_odom_base = made.odometryAt(k);
    const bool after = k == 2;  // an unrecorded optimisation came before it
    if (after) journal.appendPosesDeferred();
    journal.append(keyframe, after ? poseFromYaw(1, {50, 0, 0}) * keyframe.T_odom_base : keyframe.T_odom_base, {});
  }
  EXPECT_THAT(readJournal(file).T_map_base[2], IsNear(made.odometryAt(2), 1e-12, 1e-9));
  EXPECT_TRUE(readJournal(file).poses_deferred);
  journal.append({made.odometryAt(7), made.odometryAt(8), made.odometryAt(9)});
  EXPECT_EQ(readJournal(file).T_map_base[2].matrix(), made.odometryAt(9).matrix());
}

}  // namespace
}  // namespace scslam::test
