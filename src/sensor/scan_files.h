// Folders of scan files: finding, sorting and numbering them, and the tables of numbers that lie beside them.
#pragma once
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "scslam/core/stamp.h"
#include "scslam/core/trajectory.h"

namespace scslam {

/// Files of `folder` with one of these extensions (".pcd", any case), sorted naturally: 2 before 10, by digits and not
/// by characters. Empty when there is no such folder. Names that begin with a dot are passed over.
std::vector<std::filesystem::path> listFiles(const std::filesystem::path& folder,
                                             std::initializer_list<const char*> extensions);
bool naturallyLess(const std::string& a, const std::string& b);

/// The number a file is called by ("000042.pcd" is 42); nullopt when the name is anything but digits.
std::optional<std::uint64_t> numberOf(const std::filesystem::path& file);

/// An instant written as a file name: "1561000444390857630" (ns), "1561000444390857" (us), "1561000444.39" (s). The
/// unit follows from the magnitude; smaller numbers are counters and give nullopt.
std::optional<Stamp> stampOfName(const std::filesystem::path& file);

/// A table of text columns split at blanks or commas; lines that begin with # and blank lines are left out.
struct TextTable {
  std::filesystem::path file;
  struct Row {
    std::size_t line = 0;  ///< 1-based
    std::vector<std::string> cells;
  };
  std::vector<Row> rows;

  /// @throw inputError file:line when the cell is missing or no finite number.
  double number(std::size_t row, std::size_t column) const;
  /// @throw inputError file:line …
  std::int64_t integer(std::size_t row, std::size_t column) const;
};
TextTable readTextTable(const std::filesystem::path& file);

/// Which row of a file with `rows` rows belongs to each scan: row i to scan i when there are as many, otherwise the row
/// that the scan's file number names (a drive of which only some scans are there).
/// @throw inputError that says both counts, when neither fits.
std::vector<std::size_t> rowsOfScans(const std::vector<std::filesystem::path>& scans, std::size_t rows,
                                     const std::filesystem::path& table);

/// Stamps of the scans from a times file: one column of seconds (or of ns, us: by magnitude), or two: file number
/// and time, or calendar date and time of day (UTC). @throw inputError when it does not fit the scans or a time is
/// none.
std::vector<Stamp> readTimes(const std::filesystem::path& file, const std::vector<std::filesystem::path>& scans);

/// Poses of the scans from a KITTI or TUM file beside them (rowsOfScans / interpolation at the stamp).
/// @return one per scan; a TUM file may leave some out.
std::vector<std::optional<Pose>> readPosesOfScans(const std::filesystem::path& file,
                                                  const std::vector<std::filesystem::path>& scans,
                                                  const std::vector<Stamp>& stamps);

}  // namespace scslam
