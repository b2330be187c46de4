#include "scslam/graph/g2o.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/graph/components.h"
#include "scslam/graph/factor_error.h"
#include "scslam/graph/g2o_line.h"

namespace scslam {
namespace {

using detail::G2oLine;

/// Moves an indefinite matrix to the nearest positive semidefinite one. @return false when it is that already.
bool makeSemidefinite(Matrix6d& information, bool planar) {
  const Eigen::LLT<Matrix6d> llt(information);
  if (!planar && llt.info() == Eigen::Success) return false;  // the usual case, an order cheaper than eigenvalues
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(information);
  const Vector6d& values = eigen.eigenvalues();
  if (values.minCoeff() >= -1e-9 * std::max(1e-300, values.maxCoeff())) return false;
  information = eigen.eigenvectors() * values.cwiseMax(0).asDiagonal() * eigen.eigenvectors().transpose();
  return true;
}

class Reader {
 public:
  explicit Reader(const std::filesystem::path& file) : file_(file.string()) {}

  G2oFile read(const std::string& text) {
    // A vertex or edge line has at least 20 characters: the reservation stays below the size of the file.
    edges_.reserve(text.size() / 128);
    vertices_.reserve(text.size() / 128);
    std::size_t number = 0;
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      readLine(std::string_view(text).substr(begin, end - begin), ++number);
      begin = end + 1;
    }
    if (vertices_.empty() && edges_.empty())
      throw inputError("{}: no vertex and no edge in it; is it a g2o file?", file_);
    if (planar_tags_ && spatial_tags_)
      throw inputError("{}: mixes SE2 and SE3 elements; split it into two files", file_);
    placeVertices();
    placeEdges();
    placeFixed();
    result_.graph.planar = planar_tags_;
    if (indefinite_ > 0)
      result_.warnings.push_back(fmt::format(
          "{}:{}: an information matrix that is not positive semidefinite, the first of {}: each is replaced "
          "by the nearest one that is",
          file_, first_indefinite_, indefinite_));
    if (auto parts = describeParts(result_.graph, graphParts(result_.graph)); !parts.empty())
      result_.warnings.push_back(file_ + ": " + parts);
    return std::move(result_);
  }

 private:
  struct Vertex {
    std::int64_t id;
    std::size_t line;
    Pose T;
  };
  struct Edge {
    std::int64_t i, j;
    std::size_t line;
    Pose T;
    Matrix6d information;
  };

  void readLine(std::string_view text, std::size_t number) {
    G2oLine line(text, file_, number);
    const std::string_view tag = line.tag();
    if (tag.empty() || tag.front() == '#') return;
    if (tag == "VERTEX_SE3:QUAT" || tag == "VERTEX_SE2") {
      const bool planar = tag == "VERTEX_SE2";
      (planar ? planar_tags_ : spatial_tags_) = true;
      const std::int64_t id = line.id();
      vertices_.push_back({id, number, planar ? line.pose2d() : line.pose3d()});
      line.end();
    } else if (tag == "EDGE_SE3:QUAT" || tag == "EDGE_SE2") {
      readEdge(line, tag == "EDGE_SE2", number);
    } else if (tag == "FIX") {
      do fixed_.emplace_back(line.id(), number);
      while (!line.atEnd());
    } else if (std::find(unknown_.begin(), unknown_.end(), tag) == unknown_.end()) {
      unknown_.emplace_back(tag);
      result_.warnings.push_back(
          fmt::format("{}:{}: lines '{}' are left out: not a known g2o element", file_, number, tag));
    }
  }

  void readEdge(G2oLine& line, bool planar, std::size_t number) {
    (planar ? planar_tags_ : spatial_tags_) = true;
    const std::int64_t i = line.id(), j = line.id();
    if (i == j) throw inputError("{}:{}: the edge joins vertex {} to itself", file_, number, i);
    const Pose T = planar ? line.pose2d() : line.pose3d();
    Matrix6d information = line.information(planar);
    line.end();
    if (information.diagonal().minCoeff() < 0)
      throw inputError("{}:{}: the information matrix of edge {} {} has a negative number on its diagonal", file_,
                       number, i, j);
    if (makeSemidefinite(information, planar) && indefinite_++ == 0) first_indefinite_ = number;
    edges_.push_back({i, j, number, T, information});
  }

  void placeVertices() {
    std::stable_sort(vertices_.begin(), vertices_.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
    for (std::size_t k = 1; k < vertices_.size(); ++k)
      if (vertices_[k].id == vertices_[k - 1].id)
        throw inputError("{}:{}: vertex {} was already given in line {}", file_, vertices_[k].line, vertices_[k].id,
                         vertices_[k - 1].line);
    PoseGraph& graph = result_.graph;
    result_.poses_known = !vertices_.empty();
    for (const Vertex& vertex : vertices_) graph.ids.push_back(vertex.id), graph.poses.push_back(vertex.T);
    if (result_.poses_known) return;
    for (const Edge& edge : edges_) graph.ids.push_back(edge.i), graph.ids.push_back(edge.j);
    std::sort(graph.ids.begin(), graph.ids.end());
    graph.ids.erase(std::unique(graph.ids.begin(), graph.ids.end()), graph.ids.end());
    graph.poses.assign(graph.ids.size(), Pose::Identity());
  }

  std::uint32_t indexOf(std::int64_t id, std::size_t line) const {
    const auto& ids = result_.graph.ids;
    const auto it = std::lower_bound(ids.begin(), ids.end(), id);
    if (it == ids.end() || *it != id) throw inputError("{}:{}: vertex {} is not in the file", file_, line, id);
    return static_cast<std::uint32_t>(it - ids.begin());
  }

  void placeEdges() {
    result_.graph.factors.reserve(edges_.size());
    for (const Edge& edge : edges_) {
      Factor factor;
      factor.i = indexOf(edge.i, edge.line);
      factor.j = indexOf(edge.j, edge.line);
      const std::uint32_t apart = factor.i < factor.j ? factor.j - factor.i : factor.i - factor.j;
      factor.kind = apart == 1 ? FactorKind::kOdometry : FactorKind::kLoop;
      factor.T_i_j = edge.T;
      factor.information = edge.information;
      result_.graph.factors.push_back(factor);
    }
  }

  void placeFixed() {
    auto& fixed = result_.graph.fixed;
    for (const auto& [id, line] : fixed_) fixed.push_back(indexOf(id, line));
    std::sort(fixed.begin(), fixed.end());
    fixed.erase(std::unique(fixed.begin(), fixed.end()), fixed.end());
  }

  std::string file_;
  G2oFile result_;
  std::vector<Vertex> vertices_;
  std::vector<Edge> edges_;
  std::vector<std::pair<std::int64_t, std::size_t>> fixed_;
  std::vector<std::string> unknown_;
  bool planar_tags_ = false, spatial_tags_ = false;
  std::size_t indefinite_ = 0, first_indefinite_ = 0;  ///< how many information matrices, and the first one's line
};

void writePose(fmt::memory_buffer& out, const Pose& T, bool se2) {
  if (se2) {
    fmt::format_to(std::back_inserter(out), " {:.17g} {:.17g} {:.17g}", T.translation().x(), T.translation().y(),
                   yawOf(T));
    return;
  }
  const Eigen::Quaterniond q(T.linear());
  const auto& t = T.translation();
  fmt::format_to(std::back_inserter(out), " {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}", t.x(), t.y(),
                 t.z(), q.x(), q.y(), q.z(), q.w());
}

}  // namespace

G2oFile readG2o(const std::filesystem::path& file) { return Reader(file).read(readFile(file)); }

std::string formatG2o(const PoseGraph& graph, bool as_se2) {
  const bool se2 = graph.planar && as_se2;
  const auto id = [&](std::uint32_t v) { return graph.ids.empty() ? std::int64_t{v} : graph.ids[v]; };
  fmt::memory_buffer out;
  for (std::uint32_t v = 0; v < graph.poses.size(); ++v) {
    fmt::format_to(std::back_inserter(out), "{} {}", se2 ? "VERTEX_SE2" : "VERTEX_SE3:QUAT", id(v));
    writePose(out, graph.poses[v], se2);
    out.push_back('\n');
  }
  for (const std::uint32_t v : graph.fixed) fmt::format_to(std::back_inserter(out), "FIX {}\n", id(v));
  for (const Factor& factor : graph.factors) {
    if (!isRelative(factor.kind)) continue;  // g2o has no tag for it that other readers know
    fmt::format_to(std::back_inserter(out), "{} {} {}", se2 ? "EDGE_SE2" : "EDGE_SE3:QUAT", id(factor.i), id(factor.j));
    writePose(out, factor.T_i_j, se2);
    const int axes = se2 ? 3 : 6;
    for (int r = 0; r < axes; ++r)
      for (int c = r; c < axes; ++c)
        fmt::format_to(std::back_inserter(out), " {:.17g}",
                       factor.information(se2 ? kPlanarAxes[r] : r, se2 ? kPlanarAxes[c] : c));
    out.push_back('\n');
  }
  return fmt::to_string(out);
}

}  // namespace scslam
