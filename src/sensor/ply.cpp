// readPly of cloud_files.h.
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <string_view>
#include <vector>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/ply_scalar.h"
#include "scslam/sensor/cloud_files.h"

namespace scslam {
namespace {

struct Property {
  std::string name;
  PlyScalar type = PlyScalar::kF32;
  std::size_t offset = 0;
};

struct Header {
  bool ascii = false;
  std::size_t vertices = 0, record = 0, end = 0, lines = 0;
  std::vector<Property> properties;

  int find(std::initializer_list<const char*> names) const {
    for (const char* name : names)
      for (std::size_t i = 0; i < properties.size(); ++i)
        if (properties[i].name == name) return static_cast<int>(i);
    return -1;
  }
};

void readElement(Header& header, std::istringstream& words, const std::string& where, bool& in_vertex, bool& seen) {
  std::string name, count;
  words >> name >> count;
  in_vertex = name == "vertex";
  if (!in_vertex && !seen) throw inputError("{}: element '{:.40}' before the vertices is not supported", where, name);
  if (!in_vertex) return;
  if (seen) throw inputError("{}: a second vertex element", where);
  seen = true;
  const auto [end, error] = std::from_chars(count.data(), count.data() + count.size(), header.vertices);
  if (error != std::errc{} || end != count.data() + count.size())
    throw inputError("{}: '{:.40}' is no number of vertices", where, count);
}

Header readHeader(std::string_view text, const std::string& file) {
  Header header;
  bool in_vertex = false, seen = false, format = false;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    if (end == std::string_view::npos || end - begin > 10'000) break;
    std::string line(text.substr(begin, end - begin));
    if (!line.empty() && line.back() == '\r') line.pop_back();
    begin = end + 1;
    const std::string where = fmt::format("{}:{}", file, ++header.lines);
    std::istringstream words(line);
    std::string key, a, b;
    words >> key;
    if (header.lines == 1 && line != "ply") throw inputError("{}: the first line is not 'ply'", where);
    if (header.lines == 1 || key == "comment" || key == "obj_info") continue;
    if (key == "format") {
      words >> a;
      format = true;
      header.ascii = a == "ascii";
      if (!header.ascii && a != "binary_little_endian")
        throw inputError("{}: format '{:.40}' is none of ascii, binary_little_endian", where, a);
    } else if (key == "element") {
      readElement(header, words, where, in_vertex, seen);
    } else if (key == "property") {
      if (!in_vertex) continue;
      words >> a >> b;
      if (a == "list") throw inputError("{}: a list in the vertex element is not supported", where);
      if (b.empty()) throw inputError("{}: a property without a name", where);
      const auto type = plyScalar(a);
      if (!type) throw inputError("{}: '{:.40}' is no PLY type", where, a);
      header.properties.push_back({b, *type, header.record});
      header.record += sizeOf(header.properties.back().type);
    } else if (key == "end_header") {
      header.end = begin;
      if (!format || !seen) throw inputError("{}: the header has no {}", file, format ? "vertex element" : "format");
      for (const char* name : {"x", "y", "z"})
        if (header.find({name}) < 0) throw inputError("{}: the vertices have no property '{}'", file, name);
      return header;
    } else {
      throw inputError("{}: '{:.40}' is no PLY header line", where, key);
    }
  }
  throw inputError("{}: no PLY header that ends in end_header", file);
}

/// value(point, property) in both encodings.
template <class Value>
Cloud assemble(const Header& header, const Value& value) {
  Cloud cloud;
  const auto fill = [&]<class T>(std::vector<T>& to, int property, double scale) {
    if (property < 0) return;
    to.resize(header.vertices);
    for (std::size_t i = 0; i < header.vertices; ++i)
      to[i] = static_cast<T>(value(i, static_cast<std::size_t>(property)) * scale);
  };
  fill(cloud.x, header.find({"x"}), 1);
  fill(cloud.y, header.find({"y"}), 1);
  fill(cloud.z, header.find({"z"}), 1);
  fill(cloud.intensity, header.find({"intensity", "reflectance", "scalar_intensity"}), 1);
  const int time = header.find({"t", "time", "dt", "timestamp"});
  if (time >= 0) {
    const PlyScalar type = header.properties[static_cast<std::size_t>(time)].type;
    fill(cloud.dt, time, type == PlyScalar::kF32 || type == PlyScalar::kF64 ? 1.0 : 1e-9);
  }
  const int ring = header.find({"ring", "channel"});
  if (ring >= 0) {
    cloud.ring.resize(header.vertices);
    for (std::size_t i = 0; i < header.vertices; ++i) {
      const double number = value(i, static_cast<std::size_t>(ring));
      cloud.ring[i] = number >= 0 && number <= 65535 ? static_cast<std::uint16_t>(number) : std::uint16_t{65535};
    }
  }
  return cloud;
}

Cloud readAscii(const Header& header, std::string_view data, const std::string& file) {
  const std::size_t columns = header.properties.size();
  if (header.vertices > data.size() / (2 * columns) + 1)
    throw inputError("{}: {} vertices stated, more than {} bytes can hold", file, header.vertices, data.size());
  std::vector<double> values;
  values.reserve(header.vertices * columns);
  std::size_t line_number = header.lines, begin = 0;
  for (std::size_t i = 0; i < header.vertices; ++i) {
    if (begin >= data.size())
      throw inputError("{}:{}: ends after {} of {} vertices", file, line_number, i, header.vertices);
    const std::size_t end = std::min(data.find('\n', begin), data.size());
    std::istringstream words(std::string(data.substr(begin, end - begin)));
    begin = end + 1, ++line_number;
    std::string word;
    std::size_t n = 0;
    for (; words >> word; ++n) {
      char* rest = nullptr;
      values.push_back(std::strtod(word.c_str(), &rest));
      if (*rest != 0) throw inputError("{}:{}: '{:.40}' is not a number", file, line_number, word);
    }
    if (n != columns) throw inputError("{}:{}: {} numbers, the header says {}", file, line_number, n, columns);
  }
  return assemble(header, [&](std::size_t i, std::size_t property) { return values[i * columns + property]; });
}

}  // namespace

Cloud readPly(const std::filesystem::path& path) {
  const std::string text = readFile(path), file = path.string();
  const Header header = readHeader(text, file);
  const std::string_view data = std::string_view(text).substr(header.end);
  if (header.ascii) return readAscii(header, data, file);
  if (header.vertices > data.size() / header.record)
    throw inputError("{}: {} vertices of {} bytes stated, but the file ends at byte {} after {} of them", file,
                     header.vertices, header.record, text.size(), data.size() / header.record);
  return assemble(header, [&](std::size_t i, std::size_t property) {
    const Property& p = header.properties[property];
    return plyValue(data.data() + i * header.record + p.offset, p.type);
  });
}

}  // namespace scslam
