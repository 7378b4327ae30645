#include "pathgen/part_file/cad_stream.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string_view>

#include "kinematics/basics/decimal.h"

namespace tiltfeed::pathgen {
namespace {

static_assert(std::endian::native == std::endian::little, "the stream is little-endian, as its writer is");
constexpr std::string_view kMagic = "TFCAD 1\n";
constexpr std::uint32_t kNoColour = 0xffffffffu;

std::uint32_t check_sum(const char* bytes, std::size_t size) {
  // zlib takes 32 bits of length at a time.
  uLong sum = ::crc32(0, nullptr, 0);
  for (std::size_t at = 0; at < size;) {
    const std::size_t step = std::min<std::size_t>(size - at, 1u << 30);
    sum = ::crc32(sum, reinterpret_cast<const Bytef*>(bytes + at), static_cast<uInt>(step));
    at += step;
  }
  return static_cast<std::uint32_t>(sum);
}

class Writer {
 public:
  template <class T>
  void put(const T& value) {
    out.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void text(const std::string& value) {
    put(static_cast<std::uint32_t>(value.size()));
    out += value;
  }
  template <class T>
  void list(const std::vector<T>& values) {
    put(static_cast<std::uint32_t>(values.size()));
    out.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  std::string out;
};

/// After the first thing that is not there nothing is read any more.
class Reader {
 public:
  explicit Reader(std::span<const char> bytes) : bytes_(bytes) {}
  template <class T>
  T get() {
    T value{};
    if (const char* at = take(sizeof value)) std::memcpy(&value, at, sizeof value);
    return value;
  }
  std::string text() {
    const auto size = get<std::uint32_t>();
    const char* at = take(size);
    return at == nullptr ? "" : std::string(at, size);
  }
  template <class T>
  std::vector<T> list() {
    const auto count = get<std::uint32_t>();
    std::vector<T> values;
    if (const char* at = take(count * sizeof(T))) {
      values.resize(count);
      if (count > 0) std::memcpy(static_cast<void*>(values.data()), at, count * sizeof(T));
    }
    return values;
  }
  bool good() const { return good_; }
  std::size_t left() const { return bytes_.size(); }

 private:
  const char* take(std::size_t size) {
    good_ = good_ && size <= bytes_.size();
    if (!good_) return nullptr;
    const char* at = bytes_.data();
    bytes_ = bytes_.subspan(size);
    return at;
  }
  std::span<const char> bytes_;
  bool good_ = true;
};

std::string name_of(const PartFace& face, std::size_t number) {
  return face.entity.empty() ? "face " + std::to_string(number + 1) : face.entity;
}

/// Of all facets together: single slivers may stand anyhow.
bool turned_over(const FaceFacets& face) {
  double agree = 0.0;
  for (const auto& [a, b, c] : face.facets) {
    const Vec3 area = cross(face.corners[b] - face.corners[a], face.corners[c] - face.corners[a]);
    agree += dot(area, face.normals[a] + face.normals[b] + face.normals[c]);
  }
  return agree < 0.0;
}

Result<void> add_facets(const FaceFacets& face, std::size_t number, const std::string& name,
                        PartModel& model) {
  const PartFace& of = model.faces[number];
  if (face.normals.size() != face.corners.size())
    return fail(Code::kInput, name + ": the stream of tiltfeed-cad has " +
                                  std::to_string(face.normals.size()) + " normals for " +
                                  std::to_string(face.corners.size()) + " corners");
  for (const Point<Part> p : face.corners)
    if (!is_finite(p) || std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) > kMaxCoordinate)
      return fail(Code::kMesh, name + ": " + name_of(of, number) + " has a corner at " + to_string(p) +
                                   " mm, beyond the limit of " + number_text(kMaxCoordinate, 7) +
                                   " mm; move the part to its origin, or check its unit");
  if (model.mesh.facets.size() + face.facets.size() > kMaxFacets)
    return fail(Code::kLimit, name + ": over the limit of " + std::to_string(kMaxFacets) + " facets at " +
                                  name_of(of, number) + "; use a larger tolerance_mm");
  for (const auto& [a, b, c] : face.facets) {
    if (std::max({a, b, c}) >= face.corners.size())
      return fail(Code::kInput, name + ": the stream of tiltfeed-cad names a corner that is not there");
    model.mesh.facets.push_back({face.corners[a], face.corners[b], face.corners[c]});
    model.face_of.push_back(static_cast<std::uint32_t>(number));
  }
  return {};
}

}  // namespace

std::string cad_stream(const PartModel& model, const std::vector<FaceFacets>& facets) {
  Writer w;
  w.out = kMagic;
  w.text(model.format), w.text(model.unit), w.put(model.unit_mm), w.put(model.allowed);
  w.put(static_cast<std::uint32_t>(model.mesh.warnings.size()));
  for (const std::string& warning : model.mesh.warnings) w.text(warning);
  w.put(static_cast<std::uint32_t>(model.bodies.size()));
  for (const PartBody& body : model.bodies)
    w.text(body.name), w.text(body.product), w.put(static_cast<std::uint8_t>(body.closed));
  w.put(static_cast<std::uint32_t>(model.faces.size()));
  for (std::size_t i = 0; i < model.faces.size(); ++i) {
    const PartFace& face = model.faces[i];
    w.put(face.body), w.text(face.name), w.put(face.colour.value_or(kNoColour));
    w.text(face.surface), w.text(face.entity), w.put(face.deviation);
    w.list(facets[i].corners), w.list(facets[i].normals), w.list(facets[i].facets);
  }
  w.put(check_sum(w.out.data(), w.out.size()));
  return std::move(w.out);
}

Result<PartModel> read_cad_stream(std::span<const char> bytes, const std::string& name) {
  const auto broken = [&](const char* what) {
    return fail(Code::kInput, name + ": the stream of tiltfeed-cad " + what + "; install both programs anew");
  };
  if (bytes.size() < kMagic.size() + sizeof(std::uint32_t)) return broken("is cut short");
  if (std::string_view(bytes.data(), kMagic.size()) != kMagic) return broken("is of another version");
  const std::size_t end = bytes.size() - sizeof(std::uint32_t);
  std::uint32_t stated = 0;
  std::memcpy(&stated, bytes.data() + end, sizeof stated);
  if (stated != check_sum(bytes.data(), end)) return broken("has a wrong check sum");
  Reader r(bytes.subspan(kMagic.size(), end - kMagic.size()));
  PartModel model;
  model.format = r.text(), model.unit = r.text();
  model.unit_mm = r.get<double>(), model.allowed = r.get<double>();
  for (auto n = r.get<std::uint32_t>(); n > 0 && r.good(); --n) model.mesh.warnings.push_back(r.text());
  for (auto n = r.get<std::uint32_t>(); n > 0 && r.good(); --n) {
    PartBody body;
    body.name = r.text(), body.product = r.text(), body.closed = r.get<std::uint8_t>() != 0;
    model.bodies.push_back(std::move(body));
  }
  const auto count = r.get<std::uint32_t>();
  for (std::uint32_t i = 0; i < count && r.good(); ++i) {
    PartFace face;
    face.body = r.get<std::uint32_t>(), face.name = r.text();
    if (const auto colour = r.get<std::uint32_t>(); colour != kNoColour) face.colour = colour;
    face.surface = r.text(), face.entity = r.text(), face.deviation = r.get<double>();
    FaceFacets facets;
    facets.corners = r.list<Point<Part>>(), facets.normals = r.list<Vec3>();
    facets.facets = r.list<std::array<std::uint32_t, 3>>();
    if (!r.good()) break;
    if (face.body >= model.bodies.size()) return broken("names a body that is not there");
    model.deviation = std::max(model.deviation, face.deviation);
    model.faces.push_back(std::move(face));
    if (auto added = add_facets(facets, i, name, model); !added) return tl::unexpected(added.error());
    if (turned_over(facets))
      model.mesh.warnings.push_back(name + ": the facets of " + name_of(model.faces[i], i) +
                                    " are turned against the normals of its surface");
  }
  if (!r.good()) return broken("is cut short");
  if (r.left() > 0) return broken("has bytes after its end");
  return model;
}

}  // namespace tiltfeed::pathgen
