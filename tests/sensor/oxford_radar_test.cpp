// The Oxford PNG layout: real files, our own files, damaged files.
#include "scslam/sensor/oxford_radar.h"

#include <cmath>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "support/support.h"

namespace scslam {
namespace {

using testing::HasSubstr;

RadarScan aScan(std::size_t azimuths = 40, std::size_t bins = 200) {
  RadarScan scan;
  scan.resize(azimuths, bins);
  for (std::size_t i = 0; i < azimuths; ++i) {
    scan.stamps[i] = stampFromNanoseconds(1547131046353776000 + 625000 * static_cast<std::int64_t>(i));
    scan.angles[i] = 2 * M_PI * static_cast<double>(14 * i + 13) / kNavtechEncoderCounts;
    for (std::size_t k = 0; k < bins; ++k) scan.row(i)[k] = static_cast<std::uint8_t>(i * 31 + k * k);
  }
  scan.valid[3] = 0;
  return scan;
}

std::string refusal(std::string_view bytes) {
  try {
    decodeOxfordRadar(bytes, "a.png");
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    EXPECT_THAT(error.what(), HasSubstr("a.png"));
    return error.what();
  }
  return "";
}

TEST(OxfordRadar, WhatIsWrittenIsReadBack) {
  const RadarScan scan = aScan();
  const std::string bytes = encodeOxfordRadar(scan);
  EXPECT_EQ(bytes, encodeOxfordRadar(scan));
  OxfordRadarFormat format;
  format.range_resolution_m = 0.0596, format.range_offset_m = -0.31, format.label = "navtech";
  const RadarScan read = decodeOxfordRadar(bytes, "a.png", format);
  EXPECT_EQ(read.azimuths, scan.azimuths);
  EXPECT_EQ(read.bins, scan.bins);
  EXPECT_EQ(read.power, scan.power);
  EXPECT_EQ(read.stamps, scan.stamps);
  EXPECT_EQ(read.valid, scan.valid);
  for (std::size_t i = 0; i < scan.azimuths; ++i) EXPECT_NEAR(read.angles[i], scan.angles[i], 1e-12);
  EXPECT_NEAR(read.rangeAt(0.5), 0.0298 - 0.31, 1e-12);
  EXPECT_EQ(read.label, "navtech");
}

TEST(OxfordRadar, RealImagesAreReadAndWrittenBackByteForByte) {
  SCSLAM_NEEDS_DATA(folder, "oxford_radar_tiny/radar");
  int images = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const RadarScan scan = readOxfordRadar(entry.path());
    ++images;
    EXPECT_EQ(scan.azimuths, 400U);
    EXPECT_EQ(scan.bins, 3768U);
    EXPECT_EQ(formatStamp(scan.stamps[0]).substr(0, 17), entry.path().stem().string().insert(10, "."));
    EXPECT_NEAR(secondsBetween(scan.stamps.front(), scan.stamps.back()), 0.25, 0.01);
    for (std::size_t i = 1; i < 400; ++i)
      EXPECT_NEAR(std::remainder(scan.angles[i] - scan.angles[i - 1], 2 * M_PI), 2 * M_PI / 400, 2e-2);
    const RadarScan again = decodeOxfordRadar(encodeOxfordRadar(scan), "again");
    EXPECT_EQ(again.power, scan.power);
    EXPECT_EQ(again.stamps, scan.stamps);
    EXPECT_EQ(again.angles, scan.angles);
    EXPECT_EQ(again.valid, scan.valid);
  }
  EXPECT_EQ(images, 11);
}

TEST(OxfordRadar, CutOrFlippedFilesAreRefusedOrReadWhole) {
  const std::string good = encodeOxfordRadar(aScan());
  for (std::size_t cut = 0; cut < good.size(); cut += 97) EXPECT_NE(refusal(good.substr(0, cut)), "") << cut;
  for (std::size_t at = 0; at < good.size(); at += 13) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 0x40);
    refusal(bad);
  }
}

TEST(OxfordRadar, OtherPicturesAreRefused) {
  EXPECT_THAT(refusal("no picture at all"), HasSubstr("Oxford layout"));
  RadarScan narrow = aScan(4, 1);
  std::string bytes = encodeOxfordRadar(narrow);
  EXPECT_EQ(refusal(bytes), "");
  RadarScan back = aScan();
  std::swap(back.stamps[10], back.stamps[11]);
  EXPECT_THAT(refusal(encodeOxfordRadar(back)), HasSubstr("row 11 is before"));
  EXPECT_THROW(readOxfordRadar("/nowhere/at/all.png"), Error);
}

TEST(OxfordRadar, ScansThatNoFileCanHoldAreRefused) {
  EXPECT_THROW(encodeOxfordRadar({}), Error);
  RadarScan scan = aScan();
  scan.stamps[7] = stampFromSeconds(-5);
  EXPECT_THROW(encodeOxfordRadar(scan), Error);
  scan = aScan();
  scan.angles[1] = std::nan("");
  EXPECT_THROW(encodeOxfordRadar(scan), Error);
}

}  // namespace
}  // namespace scslam
