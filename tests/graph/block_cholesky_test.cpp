#include "scslam/graph/block_cholesky.h"

#include <Eigen/Cholesky>

#include "graph/graph_fixtures.h"
#include "support/support.h"

namespace scslam::detail {
namespace {

using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

template <int B>
class BlockSystem {
 public:
  BlockSystem(std::uint32_t size, Pairs pairs, std::uint32_t seed) : n_(size), dense_(size * B, size * B) {
    std::mt19937 random(seed);
    blocks_.resize((size + pairs.size()) * B * B);
    dense_.setZero();
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      Eigen::Map<Eigen::Matrix<double, B, B>> block(blocks_.data() + (size + k) * B * B);
      for (int c = 0; c < B; ++c) block.col(c) = test::randomVector(random, 1, 1).template head<B>();
      const int i = static_cast<int>(pairs[k].first) * B, j = static_cast<int>(pairs[k].second) * B;
      dense_.template block<B, B>(i, j) = block;
      dense_.template block<B, B>(j, i) = block.transpose();
    }
    for (std::uint32_t v = 0; v < size; ++v) {
      const int at = static_cast<int>(v) * B;
      Eigen::Map<Eigen::Matrix<double, B, B>> block(blocks_.data() + std::size_t{v} * B * B);
      block = test::randomInformation(random).template topLeftCorner<B, B>();
      block.diagonal().array() += dense_.middleRows(at, B).cwiseAbs().sum();
      dense_.template block<B, B>(at, at) = block;
    }
    symbolic_ = std::make_shared<BlockSymbolic>(size, pairs);
  }

  void expectSolvesLikeDense(double damping) {
    BlockCholesky<B> cholesky(symbolic_);
    Eigen::MatrixXd damped = dense_;
    damped.diagonal() *= 1 + damping;
    for (int round = 0; round < 2; ++round) {  // the second uses memory that the first has filled
      ASSERT_TRUE(cholesky.factor(blocks_, damping));
      std::vector<double> x(std::size_t{n_} * B);
      for (std::size_t k = 0; k < x.size(); ++k) x[k] = std::sin(double(k));
      const Eigen::VectorXd b = Eigen::Map<const Eigen::VectorXd>(x.data(), static_cast<int>(x.size()));
      cholesky.solve(x);
      const Eigen::VectorXd got = Eigen::Map<const Eigen::VectorXd>(x.data(), b.size());
      EXPECT_LT((damped * got - b).norm(), 1e-10 * b.norm());
    }
  }

  std::vector<double>& blocks() { return blocks_; }
  std::shared_ptr<const BlockSymbolic> symbolic() { return symbolic_; }

 private:
  std::uint32_t n_;
  Eigen::MatrixXd dense_;
  std::vector<double> blocks_;
  std::shared_ptr<const BlockSymbolic> symbolic_;
};

Pairs randomPairs(std::uint32_t size, std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  Pairs pairs;
  for (std::uint32_t v = 1; v < size; ++v) pairs.emplace_back(v - 1, v);
  while (size > 2 && count-- > 0) {
    const std::uint32_t a = random() % size, b = random() % size;
    if (a != b) pairs.emplace_back(std::min(a, b), std::max(a, b));
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

TEST(BlockCholesky, SolvesLikeADenseSolver) {
  for (const std::uint32_t size : {1u, 2u, 3u, 10u, 60u})
    for (const std::size_t loops : {0u, 5u, 60u, 600u}) {
      BlockSystem<6>(size, randomPairs(size, loops, size), 1).expectSolvesLikeDense(0);
      BlockSystem<3>(size, randomPairs(size, loops, size + 1), 2).expectSolvesLikeDense(0.5);
    }
}

TEST(BlockCholesky, SolvesSeveralUnconnectedParts) {
  BlockSystem<6>(7, {{0, 3}, {1, 2}, {2, 5}}, 4).expectSolvesLikeDense(0);
}

TEST(BlockCholesky, RefusesMatricesThatAreNotPositiveDefinite) {
  BlockSystem<6> system(5, randomPairs(5, 3, 1), 9);
  system.blocks()[2 * 36 + 14] = -1;  // diagonal block of variable 2, element (2, 2)
  EXPECT_FALSE(BlockCholesky<6>(system.symbolic()).factor(system.blocks(), 0));
  system.blocks()[2 * 36 + 14] = std::nan("");
  EXPECT_FALSE(BlockCholesky<6>(system.symbolic()).factor(system.blocks(), 0));
}

}  // namespace
}  // namespace scslam::detail
