#include "pathgen/free_slices/stack_share.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace tiltfeed::pathgen {

namespace {

/// The part's box is cut into at most so many cells each way.
constexpr double kCellsAcross = 160.0;

struct Range {
  double low = 0.0, high = 0.0;
};
using Extent = std::array<Range, 3>;

Extent extent_of(const ClSections& sections, std::uint32_t patch) {
  Extent e;
  const std::array<Vec3, 3> axes{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [low, high] = sections.extent(patch, axes[k]);
    e[k] = {low, high};
  }
  return e;
}

/// Boxes marked on a grid of cells.
class CellMarks {
 public:
  CellMarks(const Extent& whole, double least_cell) : whole_(whole) {
    double widest = 0.0;
    for (const Range& r : whole) widest = std::max(widest, r.high - r.low);
    cell_ = std::max(least_cell, widest / kCellsAcross);
    for (std::size_t k = 0; k < 3; ++k)
      count_[k] = static_cast<std::size_t>((whole[k].high - whole[k].low) / cell_) + 1;
    marks_.assign(count_[0] * count_[1] * count_[2], 0);
  }
  /// All cells that the box, wider by `margin`, overlaps.
  void mark(const Extent& box, double margin) {
    each(box, margin, [](std::uint8_t& m) { return m = 1, false; });
  }
  bool meets(const Extent& box) {
    return each(box, 0.0, [](std::uint8_t m) { return m != 0; });
  }

 private:
  template <class Visit>
  bool each(const Extent& box, double margin, const Visit& visit) {
    std::array<std::size_t, 3> first, last;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto index = [&](double v) {
        const double at = std::floor((v - whole_[k].low) / cell_);
        return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(count_[k] - 1)));
      };
      first[k] = index(box[k].low - margin), last[k] = index(box[k].high + margin);
    }
    for (std::size_t x = first[0]; x <= last[0]; ++x)
      for (std::size_t y = first[1]; y <= last[1]; ++y)
        for (std::size_t z = first[2]; z <= last[2]; ++z)
          if (visit(marks_[(x * count_[1] + y) * count_[2] + z])) return true;
    return false;
  }

  Extent whole_;
  double cell_ = 1.0;
  std::array<std::size_t, 3> count_{};
  std::vector<std::uint8_t> marks_;
};

/// The least and the largest lean of the normals from a plane square to the direction, as a cosine.
Range leans(const NormalCap& normals, Vec3 direction) {
  const auto [low, high] = normals.along(direction);
  return {low > 0.0 ? low : high < 0.0 ? -high : 0.0, std::max(std::abs(low), std::abs(high))};
}

bool may_own(std::uint32_t stack, const NormalCap& normals, const std::vector<Vec3>& planes) {
  const double own = leans(normals, planes[stack]).low;
  return std::none_of(planes.begin(), planes.end(),
                      [&](Vec3 other) { return leans(normals, other).high < own; });
}

/// What of the box is in the containment, if anything.
std::optional<Extent> within(Extent box, const Containment& c) {
  const std::array<const Interval*, 3> sides{&c.first, &c.second, &c.height};
  for (std::size_t k = 0; k < 3; ++k) {
    box[k] = {std::max(box[k].low, sides[k]->low), std::min(box[k].high, sides[k]->high)};
    if (box[k].high < box[k].low) return std::nullopt;
  }
  return box;
}

}  // namespace

bool owned_by(std::uint32_t stack, Vec3 n, const PlanOptions& options) {
  const std::vector<Vec3>& planes = options.free.plane_normals;
  const double own = std::abs(dot(n, planes[stack]));
  for (std::uint32_t i = 0; i < planes.size(); ++i) {
    const double other = std::abs(dot(n, planes[i]));
    if (other < own || (other == own && i < stack)) return false;
  }
  return true;
}

std::vector<std::uint8_t> stack_share(const ClSections& sections, std::uint32_t stack,
                                      const PlanOptions& options, double margin) {
  std::vector<std::uint8_t> needed(sections.patches(), 0);
  if (needed.empty()) return needed;
  std::vector<Extent> boxes;
  boxes.reserve(needed.size());
  for (std::uint32_t p = 0; p < sections.patches(); ++p) boxes.push_back(extent_of(sections, p));
  Extent whole = boxes.front();
  for (const Extent& box : boxes)
    for (std::size_t k = 0; k < 3; ++k)
      whole[k] = {std::min(whole[k].low, box[k].low), std::max(whole[k].high, box[k].high)};
  CellMarks marks(whole, margin / 2.0);
  for (std::uint32_t p = 0; p < sections.patches(); ++p) {
    const std::optional<Extent> inside = within(boxes[p], options.containment);
    if (inside && may_own(stack, sections.normals(p), options.free.plane_normals))
      needed[p] = 1, marks.mark(*inside, margin);
  }
  for (std::uint32_t p = 0; p < sections.patches(); ++p)
    if (needed[p] == 0 && marks.meets(boxes[p])) needed[p] = 1;
  return needed;
}

}  // namespace tiltfeed::pathgen
