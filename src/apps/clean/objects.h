// A scan taken apart into things that touch nothing else.
#pragma once
#include <cstdint>
#include <vector>

#include "scslam/core/cloud.h"

namespace scslam {

/// Cells of a scan that grow with the range as its points do: about gap_m wide up to 15 m, wider beyond.
class ScanCells {
 public:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  /// @param cloud_sensor frame sensor. @param of points with 0 lie in no cell.
  ScanCells(const Cloud& cloud_sensor, const std::vector<std::uint8_t>& of, double gap_m);

  std::size_t size() const { return neighbours_.size(); }
  std::uint32_t cellOf(std::size_t point) const { return cell_[point]; }
  /// Numbers the groups of cells that touch each other (corners count), by their first cell.
  /// @param of cells with 0 belong to no group. @param groups their count.
  std::vector<std::uint32_t> groups(const std::vector<std::uint8_t>& of, std::size_t& groups) const;

 private:
  std::vector<std::uint32_t> cell_;                     ///< by point
  std::vector<std::vector<std::uint32_t>> neighbours_;  ///< by cell
};

}  // namespace scslam
