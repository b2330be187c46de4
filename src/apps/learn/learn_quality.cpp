#include "scslam/apps/learn/learn_quality.h"

#include <cmath>

#include "scslam/apps/evaluate.h"
#include "scslam/apps/learn/logistic.h"
#include "scslam/apps/saved_map.h"
#include "scslam/core/counter_random.h"
#include "scslam/core/error.h"
#include "scslam/core/progress.h"
#include "scslam/pipeline/loop_scans.h"

namespace scslam {
namespace {

constexpr std::size_t kMostKeyframes = 150;  ///< of a session
constexpr double kNear_m = 5, kElsewhere_m = 20;
constexpr double kRight_m = 1, kRightDeg = 5;
struct Start {
  double metres, degrees;
};
constexpr Start kStarts[] = {{0.5, 2}, {2, 10}, {5, 30}, {8, 60}};

Eigen::VectorXd asVector(const AlignmentFeatures& f) { return Eigen::Vector3d(f.blur, f.shared, f.rmse_m); }

/// The examples of one session.
class Teacher {
 public:
  Teacher(const SavedMap& map, const std::vector<std::optional<Pose>>& truth, const SlamParams& slam,
          const PluginContext& context)
      : map_(map),
        truth_(truth),
        slam_(slam),
        registration_(slam.registration.method.create(context)),
        threads_(context.threads) {}

  /// Of keyframe k against the places it revisits, or not.
  void teach(KeyframeId k, RandomSequence& random, Examples& examples) {
    if (!truth_[k]) return;
    if (const auto match = placeOf(k, 0, kNear_m))
      registerAll(k, *match, truth_[*match]->inverse() * *truth_[k], random, examples);
    if (const auto match = placeOf(k, kElsewhere_m, 1e9, random.uniform()))
      registerAll(k, *match, Pose::Identity(), random, examples);
  }

 private:
  /// A keyframe whose true place is so far away while the way between is long; of several the nearest, or that at this
  /// share of them.
  std::optional<KeyframeId> placeOf(KeyframeId k, double from_m, double to_m, std::optional<double> share = {}) const {
    std::vector<std::pair<double, KeyframeId>> places;
    for (KeyframeId m = 0; m < map_.keyframes().size(); ++m) {
      if (!truth_[m]) continue;
      const double way = std::abs(map_.keyframes()[m].travelled_m - map_.keyframes()[k].travelled_m);
      const double away = (truth_[m]->translation() - truth_[k]->translation()).norm();
      if (way > 3 * slam_.registration.submap_reach_m && away >= from_m && away <= to_m) places.emplace_back(away, m);
    }
    if (places.empty()) return std::nullopt;
    if (!share) return std::min_element(places.begin(), places.end())->second;
    return places[static_cast<std::size_t>(*share * static_cast<double>(places.size()))].second;
  }

  void registerAll(KeyframeId k, KeyframeId match, const Pose& T_around, RandomSequence& random, Examples& examples) {
    const auto all = static_cast<KeyframeId>(map_.keyframes().size());
    const auto cloud_of = [this](KeyframeId i) { return map_.cloud(i); };
    const Cloud submap =
        loopTarget(match, map_.keyframes(), all, map_.poses(), cloud_of, slam_.registration, threads_).submap;
    const Cloud query = loopQuery(k, map_.keyframes(), all, map_.poses(), cloud_of, slam_.registration);
    const bool planar = map_.keyframes()[k].planar;
    const Pose T_true = truth_[match]->inverse() * *truth_[k];
    registration_->setTarget(submap);
    for (const Start& start : kStarts) {
      const double heading = 2 * M_PI * random.uniform(), turn = random.uniform(-1, 1);
      const Pose T_astray = poseFromYaw(turn * start.degrees * M_PI / 180,
                                        {start.metres * std::cos(heading), start.metres * std::sin(heading), 0});
      const RegistrationResult result = registration_->align(query, Pose(T_around * T_astray), planar);
      if (!result.converged) continue;
      const Vector6d error = local(T_true, result.T_target_source);
      examples.features.push_back(
          asVector(alignmentFeatures(query, submap, result, slam_.registration.gates.quality.radius_m, planar)));
      examples.yes.push_back(error.head<3>().norm() <= kRight_m && error.tail<3>().norm() <= kRightDeg * M_PI / 180);
    }
  }

  const SavedMap& map_;
  const std::vector<std::optional<Pose>>& truth_;
  const SlamParams& slam_;
  std::unique_ptr<Registration> registration_;
  ThreadPool& threads_;
};

/// Is this a place for the test? One square in four is.
bool forTest(const Eigen::Vector3d& p_truth) {
  constexpr double kSquare_m = 20;
  const auto square = [](double metres) { return static_cast<std::int64_t>(std::floor(metres / kSquare_m)); };
  return ((square(p_truth.x()) + 2 * square(p_truth.y())) & 3) == 0;
}

void append(const Examples& part, Examples& all) {
  all.features.insert(all.features.end(), part.features.begin(), part.features.end());
  all.yes.insert(all.yes.end(), part.yes.begin(), part.yes.end());
}

void teachBy(std::size_t number, const LearnOptions& options, const PluginContext& context, Examples& learn,
             Examples& test, QualityParams& quality) {
  Session session = Session::open(options.sessions[number]);
  SlamParams slam;
  loadSessionConfig(slam, session, context);
  for (const auto& assignment : options.sets) setParam(slam, assignment);
  if (number == 0) quality = slam.registration.gates.quality;
  slam.registration.gates.quality = quality;
  const std::vector<std::optional<Pose>> of_scans =
      evaluate(session, readTrajectory(options.truths[number])).T_truth_base;
  const Pose T_base_sensor = session.info().T_base_sensor;
  const SavedMap map(std::move(session), T_base_sensor, slam.registration,
                     static_cast<std::size_t>(slam.session.cloud_cache_mb * 1e6));
  std::vector<std::optional<Pose>> truth;
  for (const Keyframe& keyframe : map.keyframes())
    truth.push_back(keyframe.scan_index < of_scans.size() ? of_scans[keyframe.scan_index] : std::nullopt);
  Teacher teacher(map, truth, slam, context);
  const std::size_t n = map.keyframes().size(), step = std::max<std::size_t>(1, n / kMostKeyframes);
  RandomSequence random(CounterRandom(1, RandomStream::kDrive), static_cast<std::uint32_t>(number));
  Progress progress("registering", n, options.quiet);
  for (std::size_t k = 0; k < n; k += step) {
    if (options.stop != nullptr && *options.stop) throw Error(ExitCode::kStopped, "stopped");
    progress.update(k);
    Examples examples;
    teacher.teach(static_cast<KeyframeId>(k), random, examples);
    if (truth[k]) append(examples, forTest(truth[k]->translation()) ? test : learn);
  }
  progress.finish();
}

}  // namespace

LearnSummary learnQuality(const LearnOptions& options, const PluginContext& context) {
  if (options.sessions.empty() || options.sessions.size() != options.truths.size())
    throw usageError("{} sessions but {} files with --gt: one for each session, in their order",
                     options.sessions.size(), options.truths.size());
  LearnSummary summary;
  Examples learn, test;
  for (std::size_t s = 0; s < options.sessions.size(); ++s) teachBy(s, options, context, learn, test, summary.quality);
  if (learn.yes.empty()) throw inputError("the sessions revisit no place that their truth knows");
  const Eigen::VectorXd w = logisticWeights(learn);
  summary.quality.on = true;
  summary.quality.bias = w(0), summary.quality.blur = w(1), summary.quality.shared = w(2);
  summary.quality.rmse_m = w(3);
  summary.examples = learn.yes.size(), summary.tested = test.yes.size();
  summary.auc = areaUnderRoc(w, test);
  std::size_t right = 0, right_believed = 0, wrong_believed = 0;
  for (const bool yes : learn.yes) summary.right += yes;
  for (std::size_t i = 0; i < test.yes.size(); ++i) {
    const bool believed = logisticProbability(w, test.features[i]) >= summary.quality.min_probability;
    right += test.yes[i];
    (test.yes[i] ? right_believed : wrong_believed) += believed;
  }
  const std::size_t wrong = test.yes.size() - right;
  summary.right_believed = right > 0 ? static_cast<double>(right_believed) / static_cast<double>(right) : 1;
  summary.wrong_believed = wrong > 0 ? static_cast<double>(wrong_believed) / static_cast<double>(wrong) : 0;
  return summary;
}

std::string learnYaml(const LearnSummary& summary, const LearnOptions& options) {
  std::string names;
  for (const auto& session : options.sessions)
    names += (names.empty() ? "" : ", ") + std::filesystem::absolute(session).lexically_normal().filename().string();
  const QualityParams& q = summary.quality;
  return fmt::format(
      "# By 'scslam learn' from {}: {} registrations, {} of them right.\n"
      "# On {} others, of other places: AUC {:.4f}; believed are {:.1f} % of those that are right, {:.1f} % of the "
      "wrong.\n"
      "registration:\n  gates:\n    quality: {{on: true, min_probability: {:g}, radius_m: {:g}, bias: {:.4g}, blur: "
      "{:.4g}, shared: {:.4g}, rmse_m: {:.4g}}}\n",
      names, summary.examples, summary.right, summary.tested, summary.auc, 100 * summary.right_believed,
      100 * summary.wrong_believed, q.min_probability, q.radius_m, q.bias, q.blur, q.shared, q.rmse_m);
}

}  // namespace scslam
