#include "scslam/sensor/scan_files.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string_view>

#include "scslam/core/error.h"
#include "scslam/core/file.h"

namespace scslam {
namespace {

bool isDigit(char c) { return c >= '0' && c <= '9'; }

std::string lowerCase(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

std::vector<std::string> cellsOf(std::string_view line) {
  constexpr const char* kSeparators = " \t\r,";
  std::vector<std::string> cells;
  for (std::size_t begin = line.find_first_not_of(kSeparators); begin != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kSeparators, begin), line.size());
    cells.emplace_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kSeparators, end);
  }
  return cells;
}

/// A time in s, us or ns, exactly. Digits alone of 16 or more are us, of 18 or more ns (2001 to 2286).
std::optional<Stamp> stampOfText(const std::string& text) {
  std::int64_t ticks = 0;
  if (text.size() >= 16 && std::all_of(text.begin(), text.end(), isDigit)) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), ticks);
    if (error != std::errc{}) return std::nullopt;
    return stampFromNanoseconds(text.size() >= 18 ? ticks : ticks * 1000);
  }
  Stamp stamp;
  return parseStamp(text, stamp) ? std::optional(stamp) : std::nullopt;
}

/// "2011-09-26" "13:02:25.964389445" (KITTI raw), taken as UTC.
std::optional<Stamp> stampOfDate(const std::string& date, const std::string& time) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, used = 0;
  Stamp seconds;
  if (std::sscanf(date.c_str(), "%4d-%2d-%2d%n", &year, &month, &day, &used) != 3 ||
      static_cast<std::size_t>(used) != date.size() ||
      std::sscanf(time.c_str(), "%2d:%2d:%n", &hour, &minute, &used) != 2 ||
      static_cast<std::size_t>(used) >= time.size() ||
      !parseStamp(time.substr(static_cast<std::size_t>(used)), seconds))
    return std::nullopt;
  const std::chrono::year_month_day calendar{std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                                             std::chrono::day(static_cast<unsigned>(day))};
  if (!calendar.ok()) return std::nullopt;
  const std::int64_t days = std::chrono::sys_days(calendar).time_since_epoch().count();
  return seconds +
         (stampFromSeconds(static_cast<double>(days * 86400 + hour * 3600 + minute * 60)) - stampFromSeconds(0));
}

}  // namespace

bool naturallyLess(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (!isDigit(a[i]) || !isDigit(b[j])) {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
      continue;
    }
    const auto number = [](const std::string& s, std::size_t& at) {  // digits without leading zeros
      while (at + 1 < s.size() && s[at] == '0' && isDigit(s[at + 1])) ++at;
      const std::size_t begin = at;
      while (at < s.size() && isDigit(s[at])) ++at;
      return std::string_view(s).substr(begin, at - begin);
    };
    const auto x = number(a, i), y = number(b, j);
    if (x.size() != y.size()) return x.size() < y.size();
    if (x != y) return x < y;
  }
  if ((i < a.size()) != (j < b.size())) return j < b.size();
  return a < b;  // differ in leading zeros at most
}

std::vector<std::filesystem::path> listFiles(const std::filesystem::path& folder,
                                             std::initializer_list<const char*> extensions) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string extension = lowerCase(entry.path().extension().string());
    if (entry.path().filename().string().starts_with('.') || !entry.is_regular_file(error)) continue;
    if (std::find(extensions.begin(), extensions.end(), extension) != extensions.end()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end(),
            [](const auto& a, const auto& b) { return naturallyLess(a.filename().string(), b.filename().string()); });
  return files;
}

std::optional<std::uint64_t> numberOf(const std::filesystem::path& file) {
  const std::string stem = file.stem().string();
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), number);
  if (error != std::errc{} || end != stem.data() + stem.size()) return std::nullopt;
  return number;
}

std::optional<Stamp> stampOfName(const std::filesystem::path& file) {
  const std::string stem = file.stem().string();
  const std::size_t whole = std::min(stem.find('.'), stem.size());
  if (stem.empty() || !std::all_of(stem.begin(), stem.begin() + static_cast<std::ptrdiff_t>(whole), isDigit))
    return std::nullopt;
  const bool seconds = whole < stem.size() && whole >= 9 && whole <= 10;
  const bool ticks = whole == stem.size() && whole >= 16 && whole <= 19 && stem[0] != '0';
  return seconds || ticks ? stampOfText(stem) : std::nullopt;
}

double TextTable::number(std::size_t row, std::size_t column) const {
  const Row& r = rows.at(row);
  if (column >= r.cells.size())
    throw inputError("{}:{}: {} columns, {} are needed", file.string(), r.line, r.cells.size(), column + 1);
  const std::string& cell = r.cells[column];
  char* end = nullptr;
  const double value = std::strtod(cell.c_str(), &end);
  if (end != cell.c_str() + cell.size() || !std::isfinite(value))
    throw inputError("{}:{}: '{:.40}' is not a finite number", file.string(), r.line, cell);
  return value;
}

std::int64_t TextTable::integer(std::size_t row, std::size_t column) const {
  number(row, column);
  const std::string& cell = rows[row].cells[column];
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc{} || end != cell.data() + cell.size())
    throw inputError("{}:{}: '{:.40}' is not a whole number", file.string(), rows[row].line, cell);
  return value;
}

TextTable readTextTable(const std::filesystem::path& file) {
  const std::string text = readFile(file);
  TextTable table{file, {}};
  std::size_t line_number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    auto cells = cellsOf(std::string_view(text).substr(begin, end - begin));
    begin = end + 1, ++line_number;
    if (!cells.empty() && cells[0][0] != '#') table.rows.push_back({line_number, std::move(cells)});
  }
  return table;
}

std::vector<std::size_t> rowsOfScans(const std::vector<std::filesystem::path>& scans, std::size_t rows,
                                     const std::filesystem::path& table) {
  std::vector<std::size_t> result(scans.size());
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const auto number = rows == scans.size() ? std::optional<std::uint64_t>(i) : numberOf(scans[i]);
    if (!number || *number >= rows)
      throw inputError("{} has {} rows for {} scans, and scan {} is not the number of one of them", table.string(),
                       rows, scans.size(), scans[i].filename().string());
    result[i] = static_cast<std::size_t>(*number);
  }
  return result;
}

std::vector<Stamp> readTimes(const std::filesystem::path& file, const std::vector<std::filesystem::path>& scans) {
  const TextTable table = readTextTable(file);
  if (table.rows.empty()) throw inputError("{} holds no times", file.string());
  const std::size_t columns = table.rows[0].cells.size();
  if (columns > 2)
    throw inputError("{}:{}: {} columns; a times file has one (time) or two (file number, time)", file.string(),
                     table.rows[0].line, columns);
  const bool dated = columns == 2 && table.rows[0].cells[1].find(':') != std::string::npos;
  const auto stampAt = [&](std::size_t row) {
    const auto& cells = table.rows[row].cells;
    if (cells.size() != columns)
      throw inputError("{}:{}: {} columns, the lines above have {}", file.string(), table.rows[row].line, cells.size(),
                       columns);
    const auto stamp = dated ? stampOfDate(cells[0], cells[1]) : stampOfText(cells[columns - 1]);
    if (!stamp) throw inputError("{}:{}: '{:.40}' is not a time", file.string(), table.rows[row].line, cells.back());
    return *stamp;
  };
  std::vector<Stamp> stamps(scans.size());
  if (columns == 1 || dated) {
    const auto rows = rowsOfScans(scans, table.rows.size(), file);
    for (std::size_t i = 0; i < scans.size(); ++i) stamps[i] = stampAt(rows[i]);
    return stamps;
  }
  std::vector<std::pair<std::uint64_t, std::size_t>> row_of_number;
  for (std::size_t row = 0; row < table.rows.size(); ++row)
    row_of_number.emplace_back(static_cast<std::uint64_t>(table.integer(row, 0)), row);
  std::sort(row_of_number.begin(), row_of_number.end());
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const auto number = numberOf(scans[i]);
    const auto it = std::lower_bound(row_of_number.begin(), row_of_number.end(),
                                     std::pair<std::uint64_t, std::size_t>{number.value_or(0), 0});
    if (!number || it == row_of_number.end() || it->first != *number)
      throw inputError("{} has no time for scan {}", file.string(), scans[i].filename().string());
    stamps[i] = stampAt(it->second);
  }
  return stamps;
}

std::vector<std::optional<Pose>> readPosesOfScans(const std::filesystem::path& file,
                                                  const std::vector<std::filesystem::path>& scans,
                                                  const std::vector<Stamp>& stamps) {
  const Trajectory trajectory = readTrajectory(file);
  std::vector<std::optional<Pose>> poses(scans.size());
  if (trajectory.timed) {
    for (std::size_t i = 0; i < scans.size(); ++i) poses[i] = trajectory.at(stamps[i]);
  } else {
    const auto rows = rowsOfScans(scans, trajectory.poses.size(), file);
    for (std::size_t i = 0; i < scans.size(); ++i) poses[i] = trajectory.poses[rows[i]].T;
  }
  return poses;
}

}  // namespace scslam
