// Place recognition: CPU time of a descriptor, of a query, of the worst add, and of finding the nearest keys.
//   place_bench [INPUT]
// INPUT (any scans, e.g. a KITTI folder) gives the descriptor times and the images the made-up places are mixed from;
// without it random images serve. One thread; compare ratios, not machines.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <exception>
#include <nanoflann.hpp>
#include <random>
#include <vector>

#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "scslam/core/voxel_filter.h"
#include "scslam/place/key_index.h"
#include "scslam/place/place_recogniser.h"
#include "scslam/sensor/scan_source.h"

namespace {

using namespace scslam;

double threadCpuMs() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

template <class Work>
double cpuMs(Work&& work) {
  const double start = threadCpuMs();
  work();
  return threadCpuMs() - start;
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<std::size_t>(q * static_cast<double>(values.size())))];
}

std::unique_ptr<PlaceRecogniser> make(const std::string& name, const std::vector<std::string>& sets,
                                      const PluginContext& context) {
  const auto& entry = Registry<PlaceRecogniser>::instance().find(name);
  const auto params = entry.defaults();
  for (const auto& set : sets) setParam(*params, set);
  return entry.create(*params, context);
}

/// Mixed from two images with a shift, a gain, noise and dropouts, as if seen at another place.
class PlaceMaker {
 public:
  explicit PlaceMaker(std::vector<Descriptor> images) : images_(std::move(images)) {}
  Descriptor next() {
    const Descriptor &a = images_[random_() % images_.size()], &b = images_[random_() % images_.size()];
    const Eigen::Index shift = static_cast<Eigen::Index>(random_() % 60);
    const float mix = uniform(), gain = 0.7f + 0.6f * uniform();
    Descriptor image(a.rows(), a.cols());
    for (Eigen::Index r = 0; r < a.rows(); ++r)
      for (Eigen::Index c = 0; c < a.cols(); ++c) {
        const float height = gain * (mix * a(r, c) + (1 - mix) * b(r, (c + shift) % a.cols()));
        image(r, c) = uniform() < 0.05f || height <= 0 ? 0 : std::max(0.01f, height + 0.2f * (uniform() - 0.5f));
      }
    return image;
  }

 private:
  float uniform() { return static_cast<float>(random_() >> 8) * 0x1p-24f; }
  std::vector<Descriptor> images_;
  std::mt19937 random_{7};
};

std::vector<Descriptor> describeAll(const std::string& input, const PluginContext& context) {
  std::vector<Descriptor> images;
  std::vector<double> describe_ms, add_ms, cart_ms;
  std::size_t points = 0;
  const auto polar = make("scan_context", {}, context), cart = make("cart_context", {}, context);
  const auto source = openSource(input, context).source;
  while (const auto scan = source->next()) {
    Cloud cloud = transformed(scan->cloud, scan->T_base_sensor);
    dropNonFinite(cloud);
    Keyframe keyframe;
    keyframe.id = static_cast<KeyframeId>(images.size()), keyframe.planar = scan->planar;
    for (int repeat = 0; repeat < 5; ++repeat) {
      describe_ms.push_back(cpuMs([&] { polar->describe(keyframe, cloud); }));
      cart_ms.push_back(cpuMs([&] { cart->describe(keyframe, cloud); }));
    }
    images.push_back(polar->describe(keyframe, cloud));
    const Cloud thinned = selected(cloud, onePerVoxel(cloud, 0.3));
    add_ms.push_back(cpuMs([&] { polar->add(keyframe, images.back(), thinned); }));
    points += cloud.size();
  }
  fmt::print("{}: {} scans of {} points\n", input, images.size(), points / std::max<std::size_t>(1, images.size()));
  fmt::print("polar descriptor   median {:.3f} ms   p95 {:.3f}\n", quantile(describe_ms, 0.5),
             quantile(describe_ms, 0.95));
  fmt::print("cart descriptor    median {:.3f} ms   p95 {:.3f}\n", quantile(cart_ms, 0.5), quantile(cart_ms, 0.95));
  fmt::print("add, with 8 copies median {:.3f} ms   p95 {:.3f}\n\n", quantile(add_ms, 0.5), quantile(add_ms, 0.95));
  return images;
}

void benchQueries(const std::string& title, const std::string& name, const std::vector<std::string>& sets,
                  const std::vector<Descriptor>& images, std::size_t most, const PluginContext& context) {
  PlaceMaker maker(images);
  const auto recogniser = make(name, sets, context);
  std::vector<double> add_ms;
  for (std::size_t id = 0; id < most; ++id) {
    Keyframe keyframe;
    keyframe.id = static_cast<KeyframeId>(id), keyframe.travelled_m = 20.0 * static_cast<double>(id);
    const Descriptor image = maker.next();
    add_ms.push_back(cpuMs([&] { recogniser->add(keyframe, image); }));
    const std::size_t size = id + 1;
    if (size != 1000 && size != 10000 && size != 50000) continue;
    std::vector<double> query_ms;
    for (int i = 0; i < 100; ++i)
      query_ms.push_back(cpuMs([&] { recogniser->query(static_cast<KeyframeId>(id - static_cast<std::size_t>(i))); }));
    fmt::print("{:<34} {:>6} places: query median {:.3f} ms  p95 {:.3f}   add median {:.4f} ms  worst {:.3f}\n", title,
               size, quantile(query_ms, 0.5), quantile(query_ms, 0.95), quantile(add_ms, 0.5), quantile(add_ms, 1.0));
  }
}

/// Our scan against a k-d tree: the 50 nearest of n keys of 20 dimensions.
void benchKeys(const std::vector<Descriptor>& images) {
  using Keys = Eigen::Matrix<float, Eigen::Dynamic, 20, Eigen::RowMajor>;
  using Tree = nanoflann::KDTreeEigenMatrixAdaptor<Keys, 20>;
  PlaceMaker maker(images);
  for (const int n : {1000, 10000, 50000}) {
    Keys keys(n, 20);
    KeyIndex index(20);
    for (int k = 0; k < n; ++k) {
      keys.row(k) = maker.next().rowwise().mean().transpose();
      index.add(keys.row(k).data());
    }
    std::unique_ptr<Tree> tree;
    const double build_ms = cpuMs([&] { tree = std::make_unique<Tree>(20, std::cref(keys)); });
    std::vector<double> scan_ms, tree_ms;
    std::vector<KeyIndex::Neighbour> found;
    std::array<Eigen::Index, 50> ids{};
    std::array<float, 50> distances2{};
    for (int i = 0; i < 200; ++i) {
      const Eigen::RowVectorXf key = maker.next().rowwise().mean().transpose();
      scan_ms.push_back(cpuMs([&] { index.nearest(key.data(), static_cast<std::size_t>(n), 50, found); }));
      tree_ms.push_back(cpuMs([&] { tree->query(key.data(), 50, ids.data(), distances2.data()); }));
    }
    fmt::print("50 nearest of {:>6} keys: linear scan {:.3f} ms; k-d tree {:.3f} ms and {:.2f} ms to build\n", n,
               quantile(scan_ms, 0.5), quantile(tree_ms, 0.5), build_ms);
  }
  fmt::print("\n");
}

void run(int argc, char** argv) {
  ThreadPool threads(1);
  Log log(mrpt::system::LVL_WARN);
  const PluginContext context{threads, log};
  std::vector<Descriptor> images;
  if (argc > 1) images = describeAll(argv[1], context);
  std::mt19937 random(3);
  while (images.size() < 2)
    images.push_back(Descriptor::NullaryExpr(20, 60, [&] { return static_cast<float>(random() % 150) / 10; }));
  benchKeys(images);
  benchQueries("polar, no shifted copies", "scan_context", {"lateral_reach_m=0"}, images, 50000, context);
  benchQueries("polar, 8 shifted copies (default)", "scan_context", {}, images, 10000, context);
  benchQueries(
      "cart and flipped (20 x 40)", "cart_context", {"rows=20", "columns=40"},
      [&images] {
        std::vector<Descriptor> cut;
        for (const auto& image : images) cut.push_back(image.leftCols(40));
        return cut;
      }(),
      50000, context);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    run(argc, argv);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 3;
  }
}
