#include "sim/ply_mesh.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>
#include <string>
#include <string_view>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/ply_scalar.h"

namespace scslam::sim {

namespace {

enum class Format { kAscii, kLittle, kBig };

struct Property {
  std::string name;
  PlyScalar type = PlyScalar::kF32;
  bool is_list = false;
  PlyScalar count_type = PlyScalar::kU8;
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  Format format = Format::kAscii;
  std::vector<Element> elements;
  std::size_t end = 0;  ///< first byte of the data
};

PlyScalar scalarOf(const std::string& word, const std::string& file) {
  const auto type = plyScalar(word);
  if (!type) throw inputError("{}: '{:.40}' is no PLY type", file, word);
  return *type;
}

void readProperty(std::istringstream& words, Header& header, const std::string& file) {
  Property property;
  std::string word, count;
  words >> word;
  if (word == "list") {
    property.is_list = true;
    words >> count >> word;
    property.count_type = scalarOf(count, file);
  }
  property.type = scalarOf(word, file);
  if (!(words >> property.name) || header.elements.empty())
    throw inputError("{}: a property without a name or an element", file);
  header.elements.back().properties.push_back(property);
}

Header readHeader(std::string_view text, const std::string& file) {
  Header header;
  bool has_format = false;
  for (std::size_t begin = 0, line_number = 1; begin < text.size(); ++line_number) {
    const std::size_t end = text.find('\n', begin);
    if (end == std::string_view::npos || end - begin > 10'000) break;
    std::istringstream words(std::string(text.substr(begin, end - begin)));
    begin = end + 1;
    std::string key, name, count;
    words >> key;
    if ((line_number == 1) != (key == "ply")) throw inputError("{}: line {} is no PLY header", file, line_number);
    if (key == "format") {
      words >> name;
      has_format = true;
      if (name != "ascii" && name != "binary_little_endian" && name != "binary_big_endian")
        throw inputError("{}: '{:.40}' is no PLY format", file, name);
      header.format = name == "ascii" ? Format::kAscii : name == "binary_big_endian" ? Format::kBig : Format::kLittle;
    } else if (key == "element") {
      Element element;
      words >> element.name >> count;
      const auto [rest, error] = std::from_chars(count.data(), count.data() + count.size(), element.count);
      if (error != std::errc{} || rest != count.data() + count.size() || count.empty())
        throw inputError("{}: '{:.40}' is no number of elements", file, count);
      header.elements.push_back(std::move(element));
    } else if (key == "property") {
      readProperty(words, header, file);
    } else if (key == "end_header") {
      if (!has_format) throw inputError("{}: the header states no format", file);
      header.end = begin;
      return header;
    } else if (line_number > 1 && key != "comment" && key != "obj_info") {
      throw inputError("{}: '{:.40}' is no PLY header line", file, key);
    }
  }
  throw inputError("{}: the PLY header does not end", file);
}

/// The numbers after the header, one by one.
class Numbers {
 public:
  Numbers(std::string_view data, Format format, std::string file)
      : data_(data), format_(format), file_(std::move(file)) {}

  double next(PlyScalar type) { return format_ == Format::kAscii ? nextWord() : nextBinary(type); }

  /// Refuses counts that the rest of the file cannot hold, before memory is asked for.
  void expect(std::size_t count, std::size_t bytes_each) const {
    if (bytes_each > 0 && count > data_.size() / bytes_each)
      throw inputError("{}: the file ends early ({} more numbers or records stated than it holds)", file_,
                       count - data_.size() / bytes_each);
  }
  std::size_t bytesOf(PlyScalar type) const { return format_ == Format::kAscii ? 1 : sizeOf(type); }

 private:
  double nextWord() {
    const auto is_space = [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '+'; };
    std::size_t begin = 0;
    while (begin < data_.size() && is_space(data_[begin])) ++begin;
    data_.remove_prefix(begin);
    if (data_.empty()) throw inputError("{}: the file ends early", file_);
    double value = 0;
    const auto [rest, error] = std::from_chars(data_.data(), data_.data() + data_.size(), value);
    const auto length = static_cast<std::size_t>(rest - data_.data());
    if (error == std::errc::invalid_argument || (length < data_.size() && !is_space(data_[length])))
      throw inputError("{}: '{:.20}' is not a number", file_, data_.substr(0, data_.find_first_of(" \t\r\n")));
    if (error == std::errc::result_out_of_range) value = std::numeric_limits<double>::infinity();
    data_.remove_prefix(length);
    return value;
  }

  double nextBinary(PlyScalar type) {
    const std::size_t size = sizeOf(type);
    if (size > data_.size()) throw inputError("{}: the file ends early", file_);
    char bytes[8] = {};
    std::copy_n(data_.data(), size, bytes);
    if (format_ == Format::kBig) std::reverse(bytes, bytes + size);
    data_.remove_prefix(size);
    return plyValue(bytes, type);
  }

  std::string_view data_;
  Format format_;
  std::string file_;
};

std::uint32_t indexOf(double value) {
  return value >= 0 && value < 4294967295.0 && value == std::floor(value) ? static_cast<std::uint32_t>(value)
                                                                          : std::uint32_t{0xFFFFFFFF};
}

void readList(Numbers& numbers, const Property& property, bool keep, PolygonMesh& mesh, const std::string& file) {
  const double stated = numbers.next(property.count_type);
  if (!(stated >= 0 && stated <= 4294967295.0)) throw inputError("{}: a list of {} entries", file, stated);
  const auto n = static_cast<std::size_t>(stated);
  numbers.expect(n, numbers.bytesOf(property.type));
  for (std::size_t i = 0; i < n; ++i) {
    const double value = numbers.next(property.type);
    if (keep) mesh.corners.push_back(indexOf(value));
  }
  if (keep) mesh.face_end.push_back(mesh.corners.size());
}

void readElement(Numbers& numbers, const Element& element, PolygonMesh& mesh, const std::string& file) {
  if (element.properties.empty()) return;
  std::size_t least = 0;
  for (const Property& property : element.properties)
    least += numbers.bytesOf(property.is_list ? property.count_type : property.type);
  numbers.expect(element.count, least);
  const bool vertices = element.name == "vertex", faces = element.name == "face";
  if (vertices) mesh.vertices.reserve(element.count);
  if (faces) mesh.face_end.reserve(element.count), mesh.corners.reserve(3 * element.count);
  for (std::size_t i = 0; i < element.count; ++i) {
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    for (const Property& property : element.properties) {
      const std::string& name = property.name;
      if (property.is_list) {
        readList(numbers, property, faces && (name == "vertex_indices" || name == "vertex_index"), mesh, file);
        continue;
      }
      const double value = numbers.next(property.type);
      if (name.size() == 1 && name[0] >= 'x' && name[0] <= 'z') p[name[0] - 'x'] = value;
    }
    if (vertices) mesh.vertices.push_back(p);
  }
}

}  // namespace

PolygonMesh readPlyMesh(const std::filesystem::path& file) {
  const std::string text = readFile(file), name = "cannot read mesh " + file.string();
  const Header header = readHeader(text, name);
  Numbers numbers(std::string_view(text).substr(header.end), header.format, name);
  PolygonMesh mesh;
  for (const Element& element : header.elements) readElement(numbers, element, mesh, name);
  return mesh;
}

}  // namespace scslam::sim
