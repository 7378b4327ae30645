#include "pathgen/mesh/ply.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <sstream>
#include <string_view>

#include "pathgen/mesh/quote.h"

namespace tiltfeed::pathgen {
namespace {

constexpr std::size_t kMostHeader = 65536;    // bytes
constexpr std::uint64_t kMostCorners = 1000;  // of a face; a list that is longer is misread

enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };
struct TypeName {
  std::string_view name;
  Type type;
};
constexpr TypeName kTypes[] = {
    {"char", Type::kInt8},     {"int8", Type::kInt8},     {"uchar", Type::kUint8},
    {"uint8", Type::kUint8},   {"short", Type::kInt16},   {"int16", Type::kInt16},
    {"ushort", Type::kUint16}, {"uint16", Type::kUint16}, {"int", Type::kInt32},
    {"int32", Type::kInt32},   {"uint", Type::kUint32},   {"uint32", Type::kUint32},
    {"float", Type::kFloat},   {"float32", Type::kFloat}, {"double", Type::kDouble},
    {"float64", Type::kDouble}};

struct Property {
  std::string name;
  Type type = Type::kFloat;
  std::optional<Type> count = {};  ///< of a list
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

enum class Form { kText, kLittle, kBig };

struct Header {
  Form form = Form::kText;
  std::vector<Element> elements;
  std::size_t size = 0;  ///< bytes
};

std::optional<Type> type_of(const std::string& name) {
  for (const TypeName& known : kTypes)
    if (known.name == name) return known.type;
  return std::nullopt;
}

class HeaderReader {
 public:
  HeaderReader(std::span<const char> bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  Result<Header> read() {
    for (bool more = true; more;) {
      const auto rest = bytes_.subspan(header_.size, std::min(kMostHeader, bytes_.size()) - header_.size);
      const auto end = std::find(rest.begin(), rest.end(), '\n');
      if (end == rest.end()) return wrong("the header has no end_header; export the part again");
      std::string text(rest.begin(), end);
      header_.size += text.size() + 1;
      ++line_;
      const Result<bool> goes_on = take(text);
      if (!goes_on) return tl::unexpected(goes_on.error());
      more = *goes_on;
    }
    if (!has_form_) return wrong("the header states no format");
    return std::move(header_);
  }

 private:
  tl::unexpected<Error> wrong(const std::string& message) const {
    return fail(Code::kInput, name_ + ": line " + std::to_string(line_) + ": " + message);
  }

  /// False behind the last line.
  Result<bool> take(const std::string& text) {
    std::istringstream words(text);
    std::string word, a, b, c, d;
    words >> word >> a >> b >> c >> d;
    if (word == "end_header") return false;
    if (word.empty() || word == "ply" || word == "comment" || word == "obj_info") return true;
    if (word == "format") {
      if (b != "1.0" || (a != "ascii" && a != "binary_little_endian" && a != "binary_big_endian"))
        return wrong("format " + quote(a) + " " + quote(b) +
                     "; expected ascii, binary_little_endian or binary_big_endian 1.0");
      header_.form = a == "ascii" ? Form::kText : a == "binary_little_endian" ? Form::kLittle : Form::kBig;
      has_form_ = true;
      return true;
    }
    if (word == "element") {
      Element element{a, 0, {}};
      const auto [end, code] = std::from_chars(b.data(), b.data() + b.size(), element.count);
      if (code != std::errc() || end != b.data() + b.size() || a.empty())
        return wrong("expected the element's name and how many there are, found " + quote(b));
      if (a == "tristrips" && element.count > 0)
        return wrong("tristrips: triangle strips cannot be read; export the part as faces");
      header_.elements.push_back(std::move(element));
      return true;
    }
    if (word != "property" || header_.elements.empty())
      return wrong(quote(word) + " is no line of a header here; export the part again");
    const bool list = a == "list";
    const auto type = type_of(list ? c : a), count = list ? type_of(b) : std::nullopt;
    if (!type || (list && (!count || *count == Type::kFloat || *count == Type::kDouble)))
      return wrong(quote(text) + ": a type that PLY does not have");
    header_.elements.back().properties.push_back({list ? d : b, *type, count});
    return true;
  }

  std::span<const char> bytes_;
  const std::string& name_;
  Header header_;
  std::uint64_t line_ = 0;
  bool has_form_ = false;
};

/// The values behind the header, one at a time.
class Values {
 public:
  Values(std::span<const char> bytes, Form form) : at_(bytes.data()), end_(at_ + bytes.size()), form_(form) {}

  /// Nothing at the end of the file, or where a text is no number of this type.
  std::optional<double> next(Type type) {
    if (form_ == Form::kText) return from_text(type);
    switch (type) {
      case Type::kInt8:
        return binary<std::int8_t, std::uint8_t>();
      case Type::kUint8:
        return binary<std::uint8_t, std::uint8_t>();
      case Type::kInt16:
        return binary<std::int16_t, std::uint16_t>();
      case Type::kUint16:
        return binary<std::uint16_t, std::uint16_t>();
      case Type::kInt32:
        return binary<std::int32_t, std::uint32_t>();
      case Type::kUint32:
        return binary<std::uint32_t, std::uint32_t>();
      case Type::kFloat:
        return binary<float, std::uint32_t>();
      case Type::kDouble:
        return binary<double, std::uint64_t>();
    }
    return std::nullopt;
  }

  /// Whether anything but white space is left.
  bool any_left() {
    if (form_ == Form::kText) skip_blanks();
    return at_ != end_;
  }
  bool at_end() const { return at_ == end_; }

 private:
  void skip_blanks() {
    while (at_ != end_ && (*at_ == ' ' || (*at_ >= '\t' && *at_ <= '\r'))) ++at_;
  }
  std::optional<double> from_text(Type type) {
    skip_blanks();
    double value = 0.0;
    const auto [stop, code] = std::from_chars(at_, end_, value);
    const bool real = type == Type::kFloat || type == Type::kDouble;
    if (code != std::errc() || (!real && value != std::floor(value))) return std::nullopt;
    if (stop != end_ && *stop != ' ' && (*stop < '\t' || *stop > '\r')) return std::nullopt;
    at_ = stop;
    return value;
  }
  template <class T, class Bits>
  std::optional<double> binary() {
    if (static_cast<std::size_t>(end_ - at_) < sizeof(T)) {
      at_ = end_;
      return std::nullopt;
    }
    Bits bits = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      const std::size_t shift = 8 * (form_ == Form::kLittle ? i : sizeof(T) - 1 - i);
      bits = static_cast<Bits>(
          bits | static_cast<Bits>(static_cast<Bits>(static_cast<unsigned char>(at_[i])) << shift));
    }
    at_ += sizeof(T);
    return static_cast<double>(std::bit_cast<T>(bits));
  }

  const char* at_;
  const char* end_;
  Form form_;
};

class Body {
 public:
  Body(std::span<const char> bytes, const Header& header, const std::string& name)
      : values_(bytes, header.form), header_(header), name_(name) {
    polygons_.place_name = "face";
  }

  Result<Polygons> read() {
    for (const Element& element : header_.elements) {
      if (element.name == "vertex" && !has(element, {"x", "y", "z"}))
        return fail(Code::kInput, name_ + ": the element vertex lacks x, y or z");
      if (element.properties.empty()) continue;
      for (std::uint64_t i = 0; i < element.count; ++i)
        if (auto taken = take(element, i); !taken) return tl::unexpected(taken.error());
    }
    if (values_.any_left())
      polygons_.warnings.push_back(name_ + ": what follows the last element is ignored");
    return std::move(polygons_);
  }

 private:
  static bool has(const Element& element, std::initializer_list<const char*> names) {
    return std::all_of(names.begin(), names.end(), [&](const char* name) {
      return std::any_of(element.properties.begin(), element.properties.end(),
                         [&](const Property& property) { return property.name == name && !property.count; });
    });
  }

  tl::unexpected<Error> wrong(const Element& element, std::uint64_t index,
                              const std::string& property) const {
    const std::string place = name_ + ": " + element.name + " " + std::to_string(index) + " of " +
                              std::to_string(element.count) + ", " + property + ": ";
    return fail(Code::kInput, place + (values_.at_end() ? "the file is cut short; export or copy it again"
                                                        : "malformed; export the part again"));
  }

  Result<void> take(const Element& element, std::uint64_t index) {
    Point<Part> point{};
    for (const Property& property : element.properties) {
      if (property.count) {
        if (auto taken = take_list(element, property, index); !taken) return taken;
        continue;
      }
      const std::optional<double> value = values_.next(property.type);
      if (!value) return wrong(element, index, property.name);
      if (property.name == "x") point.x = *value;
      if (property.name == "y") point.y = *value;
      if (property.name == "z") point.z = *value;
    }
    if (element.name == "vertex") polygons_.corners.push_back(point);
    return {};
  }

  Result<void> take_list(const Element& element, const Property& property, std::uint64_t index) {
    const bool face =
        element.name == "face" && (property.name == "vertex_indices" || property.name == "vertex_index");
    const std::optional<double> count = values_.next(*property.count);
    if (!count || *count < 0.0 || (face && *count > kMostCorners))
      return wrong(element, index, property.name);
    for (double i = 0; i < *count; ++i) {
      const std::optional<double> value = values_.next(property.type);
      if (!value || (face && (*value < 0.0 || *value > 0xFFFFFFFFu || *value != std::floor(*value))))
        return wrong(element, index, property.name);
      if (face) polygons_.corner_of.push_back(static_cast<std::uint32_t>(*value));
    }
    if (!face) return {};
    polygons_.first.push_back(polygons_.corner_of.size());
    polygons_.place.push_back(index);
    return {};
  }

  Values values_;
  const Header& header_;
  const std::string& name_;
  Polygons polygons_;
};

}  // namespace

bool looks_like_ply(std::span<const char> bytes) {
  return bytes.size() > 4 && std::memcmp(bytes.data(), "ply", 3) == 0 &&
         (bytes[3] == '\n' || bytes[3] == '\r');
}

Result<Polygons> parse_ply(std::span<const char> bytes, const std::string& name) {
  const Result<Header> header = HeaderReader(bytes, name).read();
  if (!header) return tl::unexpected(header.error());
  return Body(bytes.subspan(header->size), *header, name).read();
}

}  // namespace tiltfeed::pathgen
