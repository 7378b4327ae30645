#include "pathgen/mesh/polygons.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "kinematics/basics/decimal.h"

namespace tiltfeed::pathgen {
namespace {

/// Corners further from the plane of their polygon than this share of its size are told: what decimals leave
/// is less.
constexpr double kFlat = 1e-5;

class Fans {
 public:
  Fans(const Polygons& polygons, const std::string& name, Stl& stl)
      : polygons_(polygons), name_(name), stl_(stl) {}

  Result<void> cut(std::size_t polygon) {
    const std::span<const std::uint32_t> all(polygons_.corner_of);
    const std::uint64_t first = polygons_.first[polygon], end = polygons_.first[polygon + 1];
    points_.clear();
    for (const std::uint32_t corner : all.subspan(first, end - first)) {
      if (corner >= polygons_.corners.size())
        return fail(Code::kInput, at(polygon) + "corner " + std::to_string(corner + std::uint64_t{1}) +
                                      " of the " + std::to_string(polygons_.corners.size()) +
                                      " in the file; export the part again");
      points_.push_back(polygons_.corners[corner]);
    }
    if (points_.size() < 3)
      return fail(Code::kInput, at(polygon) + "a face of " + std::to_string(points_.size()) +
                                    " corners; expected at least 3");
    if (stl_.facets.size() + points_.size() - 2 > kMaxFacets)
      return fail(Code::kLimit, name_ + ": over the limit of " + std::to_string(kMaxFacets) +
                                    " facets; export with a coarser tolerance");
    const std::optional<std::size_t> start = points_.size() == 3 ? 0 : corner_that_sees_all();
    if (!start)
      return fail(Code::kMesh, at(polygon) + "a face of " + std::to_string(points_.size()) +
                                   " corners that is not convex; export the part as triangles");
    const auto corner = [&](std::size_t i) { return points_[(*start + i) % points_.size()]; };
    for (std::size_t i = 1; i + 1 < points_.size(); ++i)
      stl_.facets.push_back({corner(0), corner(i), corner(i + 1)});
    return {};
  }

  std::uint64_t bent = 0;
  double most_bent = 0.0;  ///< in the file's unit

 private:
  std::string at(std::size_t polygon) const {
    return name_ + ": " + polygons_.place_name + " " + std::to_string(polygons_.place[polygon]) + ": ";
  }

  /// None where every corner makes a triangle that lies the other way round. Looks how flat it is, too.
  std::optional<std::size_t> corner_that_sees_all() {
    const std::size_t count = points_.size();
    Vec3 area{};  // [Newell], twice
    for (std::size_t i = 0; i < count; ++i)
      area = area + cross(points_[i] - points_[0], points_[(i + 1) % count] - points_[0]);
    const double size = std::sqrt(length(area));
    if (!(size > 0.0) || !std::isfinite(size)) return 0;  // without area: the mesh's check drops its facets
    double off = 0.0;
    for (const Point<Part> p : points_)
      off = std::max(off, std::abs(dot(p - points_[0], area)) / length(area));
    if (off > kFlat * size) ++bent, most_bent = std::max(most_bent, off);
    for (std::size_t start = 0; start < count; ++start) {
      bool sees = true;
      for (std::size_t i = 1; sees && i + 1 < count; ++i) {
        const Point<Part> from = points_[start], a = points_[(start + i) % count],
                          b = points_[(start + i + 1) % count];
        sees = dot(cross(a - from, b - from), area) >= 0.0;
      }
      if (sees) return start;
    }
    return std::nullopt;
  }

  const Polygons& polygons_;
  const std::string& name_;
  Stl& stl_;
  std::vector<Point<Part>> points_;
};

}  // namespace

Result<Stl> facets_of(Polygons polygons, const std::string& name, double unit_mm) {
  const std::size_t count = polygons.first.size() - 1;
  if (count == 0)
    return fail(Code::kInput, name + ": no faces, only " + std::to_string(polygons.corners.size()) +
                                  " points; export the part as a mesh");
  Stl stl;
  stl.warnings = std::move(polygons.warnings);
  stl.facets.reserve(std::min<std::size_t>(count, kMaxFacets));
  Fans fans(polygons, name, stl);
  for (std::size_t i = 0; i < count; ++i)
    if (auto cut = fans.cut(i); !cut) return tl::unexpected(cut.error());
  if (fans.bent > 0)
    stl.warnings.push_back(name + ": " + std::to_string(fans.bent) + " faces are not flat, by up to " +
                           number_text(fans.most_bent * unit_mm, 4) +
                           " mm; each is cut along its diagonals from one corner");
  return stl;
}

}  // namespace tiltfeed::pathgen
