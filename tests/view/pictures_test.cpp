#include <png.h>

#include <regex>

#include "apps/session_of.h"
#include "scslam/core/image.h"
#include "scslam/view/svg_plot.h"
#include "scslam/view/top_view_png.h"
#include "scslam/view/trajectory_svg.h"
#include "session/memory_folder.h"
#include "support/support.h"

namespace scslam::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

SessionParts circle(std::size_t n) {
  SessionParts parts;
  for (std::size_t i = 0; i < n; ++i) {
    const double a = 0.2 * static_cast<double>(i);
    parts.optimised.push_back(poseFromYaw(a, {20 * std::sin(a), 20 - 20 * std::cos(a), 0}));
    parts.odometry.push_back(poseFromYaw(a, {21 * std::sin(a), 20 - 20 * std::cos(a), 0.1 * a}));
  }
  parts.cloud_sensor = [](std::size_t k) { return aRoom(2000, static_cast<std::uint32_t>(k)); };
  return parts;
}

/// Every number of every path of the SVG.
std::vector<double> pathNumbers(const std::string& svg) {
  std::vector<double> numbers;
  const std::regex path("<path d='([^']*)'"), number("-?[0-9]+(\\.[0-9]+)?");
  for (std::sregex_iterator p(svg.begin(), svg.end(), path), end; p != end; ++p) {
    const std::string d = (*p)[1];
    for (std::sregex_iterator n(d.begin(), d.end(), number); n != end; ++n) numbers.push_back(std::stod(n->str()));
  }
  return numbers;
}

struct Decoded {
  png_image image{};
  std::vector<std::uint8_t> rgb;
  explicit Decoded(const std::string& bytes) {
    image.version = PNG_IMAGE_VERSION;
    EXPECT_NE(png_image_begin_read_from_memory(&image, bytes.data(), bytes.size()), 0);
    image.format = PNG_FORMAT_RGB;
    rgb.resize(PNG_IMAGE_SIZE(image));
    EXPECT_NE(png_image_finish_read(&image, nullptr, rgb.data(), 0, nullptr), 0);
  }
};

TEST(TrajectorySvg, ShowsAllThreeTracksLoopsAndTheAte) {
  SessionParts parts = circle(40);
  parts.loops = {acceptedLoop(0, 31, parts.optimised[0].inverse() * parts.optimised[31])};
  LoopRecord refused = parts.loops[0];
  refused.accepted = false;
  parts.loops.push_back(refused);
  const Session session = sessionOf(memoryFolder() / "a<b & c", parts);
  const std::string svg = trajectorySvg(session, untimed(parts.optimised));
  EXPECT_THAT(svg, HasSubstr("ATE 0.000 m, odometry "));
  EXPECT_THAT(svg, HasSubstr("a&lt;b &amp; c"));
  EXPECT_THAT(svg, HasSubstr("1 loops"));
  EXPECT_THAT(svg, HasSubstr("1 refused"));
  EXPECT_THAT(svg, HasSubstr("ground truth"));
  EXPECT_THAT(trajectorySvg(session), Not(HasSubstr("ground truth")));
}

TEST(TrajectorySvg, StaysOnItsPageForOnePoseALineAndNone) {
  std::vector<SessionParts> all = {{}, circle(1), circle(2)};
  SessionParts line;
  for (int i = 0; i < 50; ++i) line.optimised.push_back(poseFromYaw(0, {1000.0 * i, 0, 0}));
  line.odometry = line.optimised;
  all.push_back(line);
  for (std::size_t n = 0; n < all.size(); ++n) {
    const std::string svg = trajectorySvg(sessionOf(memoryFolder() / "s", all[n]));
    EXPECT_THAT(svg, Not(HasSubstr("nan")));
    EXPECT_THAT(svg, Not(HasSubstr("inf")));
    for (const double value : pathNumbers(svg)) {
      ASSERT_GE(value, -10) << n;
      ASSERT_LE(value, 900) << n;
    }
  }
}

TEST(TrajectorySvg, AMetreIsAsLongInXAsInY) {
  Bounds bounds;
  bounds.add({{0, 0}, {10, 100}});
  bounds.pad(1, 0);
  const SvgPlot plot({50, 20, 800, 400}, bounds, true);
  const Eigen::Vector2d zero = plot.toPage({0, 0}), one = plot.toPage({1, 1});
  EXPECT_NEAR(one.x() - zero.x(), zero.y() - one.y(), 1e-9);
  EXPECT_NEAR(plot.toPage({5, 50}).x(), 450, 1e-9);
  EXPECT_NEAR(plot.toPage({5, 50}).y(), 220, 1e-9);
}

TEST(TopView, IsAPictureOfTheSizeAskedForAndTheSameEachTime) {
  const Session session = sessionOf(memoryFolder() / "s", circle(30));
  TopViewOptions options;
  options.max_pixels = 700;
  const std::string png = topViewPng(session, options);
  EXPECT_EQ(png, topViewPng(session, options));
  const Decoded picture(png);
  EXPECT_LE(std::max(picture.image.width, picture.image.height), 700u);
  std::size_t lit = 0;
  for (std::size_t i = 0; i < picture.rgb.size(); i += 3) lit += picture.rgb[i + 1] > 60;
  EXPECT_GT(lit, picture.rgb.size() / 3 / 100);
}

TEST(TopView, WorksForOneKeyframeAndForNone) {
  for (const std::size_t n : {0u, 1u}) {
    const Decoded picture(topViewPng(sessionOf(memoryFolder() / "s", circle(n))));
    EXPECT_GE(picture.image.width, 1u);
  }
}

TEST(Image, LineCoversItsMiddleAndNothingFarFromIt) {
  Image image(20, 20, {0, 0, 0});
  image.line(2, 10, 17, 10, 3, {255, 255, 255});
  const Decoded picture(image.png());
  EXPECT_EQ(picture.rgb[3 * (10 * 20 + 9)], 255);
  EXPECT_EQ(picture.rgb[3 * (14 * 20 + 9)], 0);
}

TEST(NiceNumber, IsOneTwoOrFiveAndNotSmaller) {
  EXPECT_DOUBLE_EQ(niceNumber(0.9), 1);
  EXPECT_DOUBLE_EQ(niceNumber(1.1), 2);
  EXPECT_DOUBLE_EQ(niceNumber(21), 50);
  EXPECT_DOUBLE_EQ(niceNumber(51), 100);
  EXPECT_DOUBLE_EQ(niceNumber(0.02), 0.02);
  EXPECT_DOUBLE_EQ(niceNumber(0), 1);
}

}  // namespace
}  // namespace scslam::test
