#include "scslam/core/pcd.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string_view>
#include <vector>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/lzf.h"

namespace scslam {
namespace {

struct Field {
  std::string name;
  std::size_t size = 4, count = 1;
  char type = 'F';
  std::size_t offset = 0;   ///< in a record [byte]
  std::size_t element = 0;  ///< in a line of numbers
};

struct Header {
  std::vector<Field> fields;
  std::size_t points = 0, record = 0, elements = 0;
  std::string data;
  std::size_t end = 0, lines = 0;  ///< where the data begin

  const Field* find(std::initializer_list<const char*> names) const {
    for (const char* name : names)
      for (const Field& field : fields)
        if (field.name == name && field.count == 1) return &field;
    return nullptr;
  }
};

std::vector<std::string> words(std::string_view line) {
  std::vector<std::string> result;
  for (std::size_t i = 0; i < line.size();) {
    const std::size_t begin = line.find_first_not_of(" \t\r", i);
    if (begin == std::string_view::npos) break;
    i = std::min(line.find_first_of(" \t\r", begin), line.size());
    result.emplace_back(line.substr(begin, i - begin));
  }
  return result;
}

std::size_t wholeNumber(const std::string& word, const std::string& where, const std::string& key) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size())
    throw inputError("{}: {} is '{}', not a whole number", where, key, word);
  return value;
}

/// SIZE, TYPE or COUNT: one entry per field.
void setPerField(Header& header, const std::vector<std::string>& line, const std::string& where) {
  if (line.size() - 1 != header.fields.size())
    throw inputError("{}: {} has {} entries for {} FIELDS", where, line[0], line.size() - 1, header.fields.size());
  for (std::size_t i = 0; i < header.fields.size(); ++i) {
    Field& field = header.fields[i];
    const std::string& word = line[i + 1];
    if (line[0] == "TYPE") {
      if (word != "F" && word != "U" && word != "I") throw inputError("{}: TYPE '{}' is none of F U I", where, word);
      field.type = word[0];
    } else if (line[0] == "SIZE") {
      field.size = wholeNumber(word, where, "SIZE");
      if (field.size != 1 && field.size != 2 && field.size != 4 && field.size != 8)
        throw inputError("{}: SIZE {} is none of 1 2 4 8", where, word);
    } else {
      field.count = wholeNumber(word, where, "COUNT");
      if (field.count > 100'000) throw inputError("{}: COUNT {} is absurd", where, word);
    }
  }
}

void finishHeader(Header& header, const std::string& file, std::size_t width, std::size_t height, bool has_width,
                  bool has_points) {
  if (header.fields.empty()) throw inputError("{}: the header has no FIELDS", file);
  if (height != 0 && width > std::numeric_limits<std::size_t>::max() / height)
    throw inputError("{}: WIDTH {} times HEIGHT {} is absurd", file, width, height);
  if (has_points && has_width && header.points != width * height)
    throw inputError("{}: POINTS {} is not WIDTH {} times HEIGHT {}", file, header.points, width, height);
  if (!has_points && !has_width) throw inputError("{}: the header has neither POINTS nor WIDTH", file);
  if (!has_points) header.points = width * height;
  for (Field& field : header.fields) {
    field.offset = header.record;
    field.element = header.elements;
    header.record += field.size * field.count;
    header.elements += field.count;
    if (field.type == 'F' && field.size < 4)
      throw inputError("{}: field {} is a float of {} bytes", file, field.name, field.size);
  }
  for (const char* name : {"x", "y", "z"}) {
    const Field* field = header.find({name});
    if (field == nullptr) throw inputError("{}: no field '{}' in FIELDS", file, name);
    if (field->type != 'F') throw inputError("{}: field {} has TYPE {}; coordinates are F", file, name, field->type);
  }
}

Header readHeader(std::string_view text, const std::string& file) {
  Header header;
  std::size_t width = 0, height = 1;
  bool has_width = false, has_points = false;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    if (end - begin > 100'000) break;
    const auto line = words(text.substr(begin, end - begin));
    begin = std::min(end + 1, text.size());
    const std::string where = fmt::format("{}:{}", file, ++header.lines);
    if (line.empty() || line[0][0] == '#') continue;
    const std::string& key = line[0];
    if (line.size() < 2) throw inputError("{}: '{:.40}' without a value", where, key);
    if (key == "FIELDS" || key == "COLUMNS") {
      header.fields.resize(line.size() - 1);
      for (std::size_t i = 0; i + 1 < line.size(); ++i) header.fields[i].name = line[i + 1];
    } else if (key == "SIZE" || key == "TYPE" || key == "COUNT") {
      setPerField(header, line, where);
    } else if (key == "WIDTH") {
      width = wholeNumber(line[1], where, key), has_width = true;
    } else if (key == "HEIGHT") {
      height = wholeNumber(line[1], where, key);
    } else if (key == "POINTS") {
      header.points = wholeNumber(line[1], where, key), has_points = true;
    } else if (key == "DATA") {
      header.data = line[1], header.end = begin;
      finishHeader(header, file, width, height, has_width, has_points);
      return header;
    } else if (key != "VERSION" && key != "VIEWPOINT") {
      throw inputError("{}: '{:.40}' is no PCD header line", where, key);
    }
  }
  throw inputError("{}: no PCD header that ends in a DATA line", file);
}

double valueAt(const char* p, char type, std::size_t size) {
  const auto as = [p]<class T>(T value) {
    std::memcpy(&value, p, sizeof value);
    return static_cast<double>(value);
  };
  if (type == 'F') return size == 4 ? as(0.F) : as(0.0);
  const bool sign = type == 'I';
  switch (size) {
    case 1:
      return sign ? as(std::int8_t{}) : as(std::uint8_t{});
    case 2:
      return sign ? as(std::int16_t{}) : as(std::uint16_t{});
    case 4:
      return sign ? as(std::int32_t{}) : as(std::uint32_t{});
    default:
      return sign ? as(std::int64_t{}) : as(std::uint64_t{});
  }
}

/// Times in seconds, made relative: differences are taken before the result loses digits to float.
std::vector<float> relativeTimes(const std::vector<double>& seconds) {
  double earliest = std::numeric_limits<double>::infinity();
  for (const double t : seconds)
    if (t < earliest) earliest = t;
  if (!std::isfinite(earliest) || std::abs(earliest) < 1) earliest = 0;
  std::vector<float> result(seconds.size());
  for (std::size_t i = 0; i < seconds.size(); ++i) result[i] = static_cast<float>(seconds[i] - earliest);
  return result;
}

std::uint16_t ringOf(double value) {
  return value >= 0 && value <= 65535 ? static_cast<std::uint16_t>(value) : std::uint16_t{65535};
}

/// Column of numbers in binary records.
struct BinaryColumn {
  const char* first;
  std::size_t step, size;
  char type;

  double operator()(std::size_t i) const { return valueAt(first + i * step, type, size); }
  void copyTo(std::vector<float>& to) const {
    if (type != 'F' || size != sizeof(float)) {
      for (std::size_t i = 0; i < to.size(); ++i) to[i] = static_cast<float>((*this)(i));
      return;
    }
    const char* p = first;
    for (float& value : to) {
      std::memcpy(&value, p, sizeof value);
      p += step;
    }
  }
};

/// Column of numbers already parsed.
struct TextColumn {
  const double* first;
  std::size_t step;

  double operator()(std::size_t i) const { return first[i * step]; }
  void copyTo(std::vector<float>& to) const {
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = static_cast<float>((*this)(i));
  }
};

/// `column(field)` gives one of the above: the three encodings differ only in that.
template <class Column>
Cloud assemble(const Header& header, const Column& column) {
  Cloud cloud;
  const auto floats = [&](std::vector<float>& to, const Field& field) {
    to.resize(header.points);
    column(field).copyTo(to);
  };
  floats(cloud.x, *header.find({"x"}));
  floats(cloud.y, *header.find({"y"}));
  floats(cloud.z, *header.find({"z"}));
  if (const Field* field = header.find({"intensity", "i", "reflectivity"})) floats(cloud.intensity, *field);
  if (const Field* field = header.find({"t", "time", "dt", "timestamp"})) {
    const double scale = field->type == 'F' ? 1.0 : 1e-9;
    std::vector<double> seconds(header.points);
    const auto value = column(*field);
    for (std::size_t i = 0; i < header.points; ++i) seconds[i] = value(i) * scale;
    cloud.dt = relativeTimes(seconds);
  }
  if (const Field* field = header.find({"ring", "channel"}); field != nullptr && field->type != 'F') {
    cloud.ring.resize(header.points);
    const auto value = column(*field);
    for (std::size_t i = 0; i < header.points; ++i) cloud.ring[i] = ringOf(value(i));
  }
  return cloud;
}

Cloud readBinary(const Header& header, std::string_view data, const std::string& file) {
  if (header.points > data.size() / header.record)
    throw inputError("{}: {} POINTS of {} bytes stated, but the file ends at byte {} after {} of them", file,
                     header.points, header.record, header.end + data.size(), data.size() / header.record);
  return assemble(header, [&](const Field& field) {
    return BinaryColumn{data.data() + field.offset, header.record, field.size, field.type};
  });
}

Cloud readCompressed(const Header& header, std::string_view data, const std::string& file) {
  std::uint32_t packed_size = 0, size = 0;
  if (data.size() < 8) throw inputError("{}: ends at byte {}, inside the sizes", file, header.end + data.size());
  std::memcpy(&packed_size, data.data(), 4);
  std::memcpy(&size, data.data() + 4, 4);
  if (packed_size > data.size() - 8)
    throw inputError("{}: {} compressed bytes stated at byte {}, but only {} follow", file, packed_size, header.end,
                     data.size() - 8);
  if (header.points > size / header.record || header.points * header.record != size)
    throw inputError("{}: {} POINTS of {} bytes stated, but {} bytes are packed", file, header.points, header.record,
                     size);
  std::string unpacked;
  if (!lzfDecompress(data.substr(8, packed_size), size, unpacked))
    throw inputError("{}: the compressed data from byte {} on are damaged", file, header.end + 8);
  return assemble(header, [&](const Field& field) {  // field after field, not point after point
    return BinaryColumn{unpacked.data() + field.offset * header.points, field.size, field.size, field.type};
  });
}

Cloud readAscii(const Header& header, std::string_view data, const std::string& file) {
  if (header.points > data.size() / (2 * header.elements) + 1)
    throw inputError("{}: {} POINTS stated, more than {} bytes can hold", file, header.points, data.size());
  std::vector<double> values;
  values.reserve(header.points * header.elements);
  std::size_t line_number = header.lines, begin = 0, points = 0;
  while (points < header.points) {
    if (begin >= data.size())
      throw inputError("{}:{}: ends after {} of {} POINTS", file, line_number, points, header.points);
    const std::size_t end = std::min(data.find('\n', begin), data.size());
    const auto line = words(data.substr(begin, end - begin));
    begin = end + 1, ++line_number;
    if (line.empty()) continue;
    if (line.size() != header.elements)
      throw inputError("{}:{}: {} numbers, the header says {}", file, line_number, line.size(), header.elements);
    for (const std::string& word : line) {
      char* rest = nullptr;
      values.push_back(std::strtod(word.c_str(), &rest));
      if (*rest != 0) throw inputError("{}:{}: '{:.40}' is not a number", file, line_number, word);
    }
    ++points;
  }
  return assemble(header, [&](const Field& field) {
    return TextColumn{values.data() + field.element, header.elements};
  });
}

}  // namespace

Cloud readPcd(const std::filesystem::path& path) {
  const std::string text = readFile(path), file = path.string();
  const Header header = readHeader(text, file);
  const std::string_view data = std::string_view(text).substr(header.end);
  if (header.data == "binary") return readBinary(header, data, file);
  if (header.data == "binary_compressed") return readCompressed(header, data, file);
  if (header.data == "ascii") return readAscii(header, data, file);
  throw inputError("{}:{}: DATA '{:.40}' is none of ascii binary binary_compressed", file, header.lines, header.data);
}

std::string encodePcd(const Cloud& cloud) {
  const std::size_t n = cloud.size();
  std::string bytes = fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\n"
      "COUNT 1 1 1 1\nWIDTH {}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
      n, n);
  const std::size_t begin = bytes.size();
  bytes.resize(begin + n * 16);
  char* to = bytes.data() + begin;
  for (std::size_t i = 0; i < n; ++i, to += 16) {
    const float point[4] = {cloud.x[i], cloud.y[i], cloud.z[i], cloud.hasIntensity() ? cloud.intensity[i] : 0.F};
    std::memcpy(to, point, 16);
  }
  return bytes;
}

}  // namespace scslam
