#include "scslam/apps/doctor.h"

#include "apps/session_of.h"
#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "session/folder_bytes.h"
#include "session/made_up_session.h"
#include "session/memory_folder.h"
#include "support/support.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

fs::path soundSession() {
  const fs::path folder = memoryFolder() / "s";
  const MadeUpSession made;
  made.tellAll(*SessionWriter::create(folder, made.info, false));
  return folder;
}

std::vector<std::string> damaged(const fs::path& folder) {
  std::vector<std::string> names;
  for (const DoctorCheck& check : examine(folder))
    if (!check.sound) names.push_back(check.what);
  return names;
}

void flip(const fs::path& file, std::size_t at) {
  std::string bytes = readFile(file);
  bytes.at(at) = static_cast<char>(bytes.at(at) ^ 1);
  AppendFile(file, 0).append(bytes);
}

TEST(Doctor, FindsNothingWrongWithASoundSession) {
  const fs::path folder = soundSession();
  EXPECT_THAT(damaged(folder), IsEmpty());
  EXPECT_GE(examine(folder).size(), 12u);
}

TEST(Doctor, FindsOneFlippedBitInAnyFile) {
  const fs::path folder = soundSession();
  for (const auto& [name, bytes] : bytesOf(folder)) {
    if (name == "run.log" || name == "metrics.json") continue;  // nothing to hold them against
    for (const std::size_t at : {bytes.size() / 2, bytes.size() - 2}) {
      flip(folder / name, at);
      bool found = false;
      try {
        found = !damaged(folder).empty();
      } catch (const Error&) {
        found = true;
      }
      // A g2o file only has to be a graph of the right size: a digit more or less is still one.
      EXPECT_TRUE(found || name == "singlesession_posegraph.g2o" || name == "session.yaml") << name << " at " << at;
      AppendFile(folder / name, 0).append(bytes);
    }
  }
  EXPECT_THAT(damaged(folder), IsEmpty());
}

TEST(Doctor, NamesWhatIsMissing) {
  const fs::path folder = soundSession();
  fs::remove(folder / "Scans/000004.pcd");
  fs::remove(folder / "times.txt");
  EXPECT_THAT(damaged(folder), ElementsAre("Scans", "times.txt"));
}

TEST(Doctor, RepairRebuildsEveryTextFileToTheByte) {
  const fs::path folder = soundSession();
  const auto before = bytesOf(folder);
  for (const char* name : {"times.txt", "optimized_poses.txt", "odom_poses.txt", "trajectory.tum", "odometry.tum",
                           "loops.csv", "singlesession_posegraph.g2o"})
    writeFileAtomically(folder / name, "1 2 3\n");
  EXPECT_EQ(damaged(folder).size(), 7u);
  repair(folder);
  EXPECT_EQ(bytesOf(folder), before);
}

TEST(Doctor, RepairKeepsTheReadablePartOfADamagedJournal) {
  const fs::path folder = soundSession();
  flip(folder / "journal.bin", fs::file_size(folder / "journal.bin") / 2);
  EXPECT_THROW(Session::open(folder), Error);
  EXPECT_THAT(damaged(folder), ::testing::Contains("journal.bin"));
  repair(folder);
  EXPECT_THAT(damaged(folder), IsEmpty());
  EXPECT_TRUE(fs::exists(folder / "journal.bin.damaged"));
  EXPECT_GT(Session::open(folder).keyframes().size(), 0u);
}

TEST(Doctor, KilledSessionIsSoundAndSaysWhereItGoesOn) {
  const fs::path root = memoryFolder();
  const MadeUpSession made;
  const auto writer = SessionWriter::create(root / "live", made.info, false);
  int events = 0;
  made.tellAll(*writer, [&] {
    if (++events == 40) fs::copy(root / "live", root / "killed", fs::copy_options::recursive);
  });
  AppendFile(root / "killed/journal.bin", fs::file_size(root / "killed/journal.bin")).append("torn");
  EXPECT_THAT(damaged(root / "killed"), IsEmpty());
  std::string all;
  for (const DoctorCheck& check : examine(root / "killed")) all += check.finding + "\n";
  EXPECT_THAT(all, HasSubstr("--resume goes on from keyframe"));
  EXPECT_THAT(all, HasSubstr("torn"));
}

TEST(Doctor, AnyOtherFolderIsAnError) { EXPECT_THROW(examine(memoryFolder()), Error); }

TEST(Doctor, CommandLineEndsInThreeUntilItIsRepaired) {
  const fs::path folder = soundSession();
  EXPECT_EQ(runScslam("doctor -q " + folder.string()).exit_code, 0);
  writeFileAtomically(folder / "times.txt", "0\n");
  const RunResult found = runScslam("doctor -q " + folder.string());
  EXPECT_EQ(found.exit_code, 3);
  EXPECT_THAT(found.out, HasSubstr("DAMAGED  times.txt"));
  EXPECT_EQ(runScslam("doctor -q --repair " + folder.string()).exit_code, 0);
  EXPECT_EQ(runScslam("doctor -q " + folder.string()).exit_code, 0);
}

}  // namespace
}  // namespace scslam::test
