// What every format must keep, run on each that is registered.
#include "fixtures.h"

namespace scslam {
namespace {

using test::fixtureStamp;
using test::kFixtureScans;
using testing::HasSubstr;

class EveryFormat : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { fixture_ = test::makeFixture(GetParam(), test::freshFolder()); }
  std::unique_ptr<ScanSource> open() const { return test::openQuietly(fixture_.uri).source; }
  test::Fixture fixture_;
};

void expectAsWritten(const RadarScan& sweep, std::size_t i) {
  const RadarScan expected = test::fixtureSweep(i, fixtureStamp(i));
  EXPECT_EQ(sweep.power, expected.power);
  EXPECT_EQ(sweep.stamps, expected.stamps);
  EXPECT_EQ(sweep.valid, expected.valid);
  for (std::size_t a = 0; a < expected.azimuths; ++a) EXPECT_NEAR(sweep.angles[a], expected.angles[a], 1e-9);
}

void expectAsWritten(const Cloud& cloud, std::size_t i) {
  const Cloud expected = test::fixtureCloud(i);
  EXPECT_EQ(cloud.x, expected.x);
  EXPECT_EQ(cloud.y, expected.y);
  EXPECT_EQ(cloud.z, expected.z);
  EXPECT_EQ(cloud.intensity, expected.intensity);
}

void expectSame(const Scan& a, const Scan& b) {
  EXPECT_EQ(a.index, b.index);
  EXPECT_EQ(a.stamp, b.stamp);
  EXPECT_EQ(a.cloud.x, b.cloud.x);
  EXPECT_EQ(a.cloud.ring, b.cloud.ring);
  ASSERT_EQ(a.radar != nullptr, b.radar != nullptr);
  if (a.radar) {
    EXPECT_EQ(a.radar->power, b.radar->power);
    EXPECT_EQ(a.radar->stamps, b.radar->stamps);
  }
  ASSERT_EQ(a.T_odom_base.has_value(), b.T_odom_base.has_value());
  if (a.T_odom_base) {
    EXPECT_EQ(a.T_odom_base->matrix(), b.T_odom_base->matrix());
  }
}

TEST_P(EveryFormat, IsRecognisedAndSaysWhy) {
  const auto opened = test::openQuietly(fixture_.uri);
  EXPECT_EQ(opened.format, GetParam());
  EXPECT_FALSE(opened.why.empty());
  EXPECT_FALSE(opened.source->description().empty());
}

TEST_P(EveryFormat, HandsOverEveryScanInOrderAndAsWritten) {
  const auto source = open();
  const bool radar = test::isRadarFormat(GetParam());
  EXPECT_EQ(source->planar(), radar);
  const auto scans = test::readAll(*source);
  ASSERT_EQ(scans.size(), kFixtureScans);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    EXPECT_EQ(scans[i].index, i);
    EXPECT_EQ(scans[i].stamp, fixtureStamp(i));
    ASSERT_EQ(scans[i].radar != nullptr, radar);
    if (radar)
      expectAsWritten(*scans[i].radar, i);
    else
      expectAsWritten(scans[i].cloud, i);
    EXPECT_FALSE(scans[i].label.empty());
    EXPECT_TRUE(isRigid(scans[i].T_base_sensor));
    if (scans[i].T_odom_base) {
      EXPECT_THAT(*scans[i].T_odom_base, test::IsNear(test::fixturePose(i), 1e-6, 1e-4));
    }
  }
}

TEST_P(EveryFormat, StaysAtItsEnd) {
  const auto source = open();
  test::readAll(*source);
  EXPECT_FALSE(source->next());
  source->skip(3);
  EXPECT_FALSE(source->next());
}

TEST_P(EveryFormat, StatesTheNumberOfScansTrulyOrNotAtAll) {
  EXPECT_EQ(open()->size().value_or(kFixtureScans), kFixtureScans);
}

TEST_P(EveryFormat, SkippingIsLikeTaking) {
  for (std::size_t n = 0; n <= kFixtureScans + 1; ++n) {
    const auto taken = open(), skipped = open();
    for (std::size_t i = 0; i < n; ++i) taken->next();
    skipped->skip(n);
    const auto a = test::readAll(*taken), b = test::readAll(*skipped);
    ASSERT_EQ(a.size(), b.size()) << n;
    for (std::size_t i = 0; i < a.size(); ++i) expectSame(a[i], b[i]);
  }
}

TEST_P(EveryFormat, ReadsTheSameTwice) {
  const auto a = test::readAll(*open()), b = test::readAll(*open());
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) expectSame(a[i], b[i]);
}

TEST_P(EveryFormat, TruthIsThatOfTheLayout) {
  const auto truth = open()->groundTruth();
  const bool has = GetParam() != "rawlog" && GetParam() != "session" && GetParam() != "radiate";
  ASSERT_EQ(truth.has_value(), has);
  if (!has) return;
  for (std::size_t i = 0; i < kFixtureScans; ++i) {
    const auto T = truth->at(fixtureStamp(i));
    ASSERT_TRUE(T);
    EXPECT_THAT(*T, test::IsNear(test::fixturePose(i), 1e-6, 1e-4));
  }
}

TEST_P(EveryFormat, ACutFileIsAnErrorThatNamesItAfterTheScansBefore) {
  const std::string whole = test::readBytes(fixture_.damage);
  test::writeBytes(fixture_.damage, whole.substr(0, whole.size() - 5));
  const auto source = open();
  std::size_t scans = 0;
  const std::string message = test::messageOf([&] {
    while (source->next()) ++scans;
  });
  EXPECT_THAT(message, HasSubstr(fixture_.damage.filename().string()));
  EXPECT_GE(scans, kFixtureScans - 1);
  EXPECT_FALSE(source->next()) << "after the error comes the end";
}

std::string nameOf(const testing::TestParamInfo<std::string>& info) { return info.param; }
INSTANTIATE_TEST_SUITE_P(ScanFormats, EveryFormat, testing::ValuesIn(Registry<ScanFormat>::instance().names()), nameOf);

TEST(ScanFormats, AreTheExpectedOnes) {
  EXPECT_EQ(Registry<ScanFormat>::instance().names(),
            (std::vector<std::string>{"clouds", "kitti", "mulran", "mulran_radar", "oxford_radar", "radiate", "rawlog",
                                      "session"}));
}

TEST(OpenSource, SaysWhatIsWrongWithAnInput) {
  const auto folder = test::freshFolder();
  const auto open = [](const std::filesystem::path& uri) { return test::messageOf([&] { test::openQuietly(uri); }); };
  EXPECT_THAT(open(folder / "none"), HasSubstr("does not exist"));
  EXPECT_THAT(open(folder), HasSubstr("is empty"));
  test::writeBytes(folder / "a.rawlog", "");
  EXPECT_THAT(open(folder / "a.rawlog"), HasSubstr("is empty (0 bytes)"));
  test::writeBytes(folder / "letter.doc", "Dear sir");
  EXPECT_THAT(open(folder / "letter.doc"), HasSubstr("looked for: clouds (folder of *.pcd"));
  EXPECT_THAT(open(folder), HasSubstr("velodyne/*.bin"));
  test::writeBytes(folder / "b.rawlog", "no rawlog at all, but named so");
  EXPECT_THAT(open(folder / "b.rawlog"), HasSubstr("b.rawlog: damaged at byte"));
}

}  // namespace
}  // namespace scslam
