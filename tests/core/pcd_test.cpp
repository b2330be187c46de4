#include "scslam/core/pcd.h"

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

#include "scslam/core/error.h"
#include "scslam/core/lzf.h"
#include "support/support.h"

namespace scslam {
namespace {

Cloud fourPoints() {
  Cloud cloud;
  for (int i = 0; i < 4; ++i) {
    cloud.push(static_cast<float>(i), 0.1F * static_cast<float>(i), -2.5F);
    cloud.intensity.push_back(10.F * static_cast<float>(i));
  }
  return cloud;
}

std::filesystem::path write(const std::string& content, const std::string& name = "a.pcd") {
  const auto file = std::filesystem::path(SCSLAM_TEST_TMP) / ("pcd_" + name);
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << content;
  return file;
}

std::string header(const std::string& fields, const std::string& size, const std::string& type, std::size_t n,
                   const std::string& data) {
  std::string count;
  for (const char c : type)
    if (c != ' ') count += " 1";
  return fmt::format("VERSION 0.7\nFIELDS {}\nSIZE {}\nTYPE {}\nCOUNT{}\nWIDTH {}\nHEIGHT 1\nPOINTS {}\nDATA {}\n",
                     fields, size, type, count, n, n, data);
}

template <class T>
void put(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string messageOf(const std::filesystem::path& file) {
  try {
    readPcd(file);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput);
    return error.what();
  }
  return "";
}

TEST(Pcd, ReadsBackWhatItWrote) {
  const Cloud cloud = fourPoints(), read = readPcd(write(encodePcd(cloud)));
  EXPECT_EQ(read.x, cloud.x);
  EXPECT_EQ(read.y, cloud.y);
  EXPECT_EQ(read.z, cloud.z);
  EXPECT_EQ(read.intensity, cloud.intensity);
  EXPECT_FALSE(read.hasTime() || read.hasRing());
}

TEST(Pcd, HeaderIsThatOfTheClassicSaver) {
  EXPECT_TRUE(encodePcd(fourPoints())
                  .starts_with("# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z intensity\n"
                               "SIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 4\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\n"
                               "POINTS 4\nDATA binary\n"));
}

TEST(Pcd, AllowsBytesAfterTheLastPoint) {
  EXPECT_EQ(readPcd(write(encodePcd(fourPoints()) + std::string(3908, 'x'))).size(), 4U);
}

TEST(Pcd, KeepsNanAsAValue) {
  Cloud cloud = fourPoints();
  cloud.y[1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(std::isnan(readPcd(write(encodePcd(cloud))).y[1]));
  EXPECT_TRUE(std::isnan(readPcd(write(header("x y z", "4 4 4", "F F F", 1, "ascii") + "1 nan 3\n")).y[0]));
}

TEST(Pcd, FindsFieldsInAnyOrderAndTypeAndSkipsOthers) {
  std::string bytes = header("rgb z t y ring x", "4 8 4 4 2 8", "U F U F U F", 2, "binary");
  for (int i = 0; i < 2; ++i) {
    put(bytes, std::uint32_t{7});
    put(bytes, 3.0 + i);
    put(bytes, static_cast<std::uint32_t>(50'000'000 * i));
    put(bytes, 2.F);
    put(bytes, static_cast<std::uint16_t>(5 + i));
    put(bytes, 1.0);
  }
  const Cloud cloud = readPcd(write(bytes));
  EXPECT_EQ(cloud.x, (std::vector<float>{1, 1}));
  EXPECT_EQ(cloud.z, (std::vector<float>{3, 4}));
  EXPECT_EQ(cloud.ring, (std::vector<std::uint16_t>{5, 6}));
  EXPECT_EQ(cloud.dt, (std::vector<float>{0, 0.05F}));
  EXPECT_FALSE(cloud.hasIntensity());
}

TEST(Pcd, MakesClockTimesRelativeToTheEarliest) {
  std::string bytes = header("x y z timestamp", "4 4 4 8", "F F F F", 2, "binary");
  for (const double t : {1624254615.25, 1624254615.125}) {
    for (int k = 0; k < 3; ++k) put(bytes, 1.F);
    put(bytes, t);
  }
  EXPECT_EQ(readPcd(write(bytes)).dt, (std::vector<float>{0.125F, 0}));
}

TEST(Pcd, ReadsAscii) {
  const Cloud cloud =
      readPcd(write(header("x y z intensity", "4 4 4 4", "F F F F", 2, "ascii") + "1 2 3 4\n\n-1 -2e0 .5 0\n"));
  EXPECT_EQ(cloud.x, (std::vector<float>{1, -1}));
  EXPECT_EQ(cloud.z, (std::vector<float>{3, 0.5F}));
  EXPECT_EQ(cloud.intensity, (std::vector<float>{4, 0}));
}

TEST(Pcd, ReadsCompressedFieldAfterField) {
  std::string plain;
  for (int i = 0; i < 3; ++i) put(plain, static_cast<float>(i));
  for (int i = 0; i < 6; ++i) put(plain, 0.F);
  // By hand: 12 literal bytes (x), then 4 zero bytes, then a reference of 20 bytes to one byte before.
  std::string packed;
  packed += static_cast<char>(11);
  packed += plain.substr(0, 12);
  packed += static_cast<char>(3);
  packed += std::string(4, '\0');
  packed += static_cast<char>(7 << 5);
  packed += static_cast<char>(20 - 2 - 7);
  packed += '\0';
  std::string bytes = header("x y z", "4 4 4", "F F F", 3, "binary_compressed");
  put(bytes, static_cast<std::uint32_t>(packed.size()));
  put(bytes, static_cast<std::uint32_t>(plain.size()));
  const Cloud cloud = readPcd(write(bytes + packed));
  EXPECT_EQ(cloud.x, (std::vector<float>{0, 1, 2}));
  EXPECT_EQ(cloud.y, (std::vector<float>{0, 0, 0}));
  EXPECT_EQ(cloud.z, (std::vector<float>{0, 0, 0}));
}

TEST(Lzf, RefusesReferencesOutsideAndWrongSizes) {
  std::string out;
  EXPECT_FALSE(lzfDecompress(std::string("\x20\x05", 2), 3, out));  // 6 bytes back from nothing
  EXPECT_FALSE(lzfDecompress(std::string("\x02"
                                         "ab",
                                         3),
                             3, out));  // 3 literals stated, 2 there
  EXPECT_FALSE(lzfDecompress(std::string("\x01"
                                         "ab",
                                         3),
                             3, out));  // 2 of 3 bytes
  EXPECT_FALSE(lzfDecompress(std::string("\x01"
                                         "ab",
                                         3),
                             1U << 31, out));  // absurd size
  EXPECT_TRUE(lzfDecompress(std::string("\x01"
                                        "ab",
                                        3),
                            2, out));
  EXPECT_EQ(out, "ab");
}

TEST(Pcd, RefusesLyingHeadersAndSaysWhere) {
  const std::string good = encodePcd(fourPoints());
  const auto with = [&good](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return messageOf(write(text));
  };
  using testing::HasSubstr;
  EXPECT_THAT(with("POINTS 4", "POINTS 5"), HasSubstr("POINTS 5 is not WIDTH 4 times HEIGHT 1"));
  EXPECT_THAT(with("POINTS 4", "POINTS -4"), HasSubstr("a.pcd:10: POINTS is '-4'"));
  EXPECT_THAT(with("WIDTH 4\n", "WIDTH 18446744073709551615\n"), HasSubstr("is not WIDTH"));
  EXPECT_THAT(with("HEIGHT 1", "HEIGHT 18446744073709551615"), HasSubstr("absurd"));
  EXPECT_THAT(with("FIELDS x y z intensity", "FIELDS x y w intensity"), HasSubstr("no field 'z'"));
  EXPECT_THAT(with("SIZE 4 4 4 4", "SIZE 4 4 4"), HasSubstr("a.pcd:4: SIZE has 3 entries for 4 FIELDS"));
  EXPECT_THAT(with("TYPE F F F F", "TYPE F F U F"), HasSubstr("field z has TYPE U"));
  EXPECT_THAT(with("DATA binary", "DATA base64"), HasSubstr("'base64'"));
  EXPECT_THAT(messageOf(write("")), HasSubstr("no PCD header"));
  std::string huge = good;
  huge.replace(huge.find("WIDTH 4"), 7, "WIDTH 4000000000");
  huge.replace(huge.find("POINTS 4"), 8, "POINTS 4000000000");
  EXPECT_THAT(messageOf(write(huge)), HasSubstr("4000000000 POINTS of 16 bytes stated"));
}

TEST(Pcd, EveryTruncationIsAnErrorWithTheFilesName) {
  const std::string good = encodePcd(fourPoints());
  for (std::size_t cut = 0; cut < good.size(); ++cut)
    ASSERT_THAT(messageOf(write(good.substr(0, cut), "cut.pcd")), testing::HasSubstr("cut.pcd")) << "at byte " << cut;
}

TEST(Pcd, BitFlipsEndInACloudOrAnError) {
  std::string ascii = header("x y z", "4 4 4", "F F F", 2, "ascii") + "1 2 3\n4 5 6\n";
  for (const std::string& good : {encodePcd(fourPoints()), ascii})
    for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
      std::string bad = good;
      bad[bit / 8] = static_cast<char>(bad[bit / 8] ^ (1 << (bit % 8)));
      const auto file = write(bad);
      try {
        EXPECT_LE(readPcd(file).size(), good.size());
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::kInput);
      }
    }
}

TEST(Pcd, ReadsRealScans) {
  SCSLAM_NEEDS_DATA(folder, "kitti_raw_2011_09_26_f00-21");
  const Cloud cloud = readPcd(folder / "0000000000.pcd");
  EXPECT_EQ(cloud.size(), 119978U);
  EXPECT_TRUE(cloud.hasIntensity());
}

}  // namespace
}  // namespace scslam
