#include "pathgen/free_slices/cl_slices.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "pathgen/free_slices/patch_obstacles.h"
#include "pathgen/free_slices/stack_share.h"
#include "pathgen/options/side_step.h"
#include "pathgen/progress/watch.h"

namespace tiltfeed::pathgen {

namespace {

/// (N8) Planes between planes, at most: to 1/128 of the side step.
constexpr int kMostLevels = 7;
/// Passes and gaps of a stack shorter than so many side steps are left to, or taken from, its neighbours.
constexpr double kShortestRun = 2.0;
/// Chains shorter than this, mm, are rests of trimming.
constexpr double kShortestChain = 0.01;
/// Where two strands cross at a flat angle their chords, outside of their arcs, end up to this far apart, mm.
constexpr double kWideGap = 1.0;
constexpr std::size_t kPlanesPerTurn = 64;

struct Plane {
  double height;
  int level;
};

/// On the part, of a ball grown by the allowance.
double side_step(const PlanOptions& o) {
  if (o.pattern.measure != StepMeasure::kScallop) return o.pattern.side_step;
  const double step = step_of_scallop(o.cutter.radius() + o.allowance, o.pattern.scallop);
  return o.pattern.side_step > 0.0 ? std::min(step, o.pattern.side_step) : step;
}

class Stack {
 public:
  Stack(const ClSections& sections, const FacetBvh& tree, const PlanOptions& options, std::uint32_t index,
        const ToleranceBudget& budget)
      : sections_(sections),
        tree_(tree),
        options_(options),
        index_(index),
        normal_(options.free.plane_normals[index]),
        step_(side_step(options)),
        budget_(budget) {
    std::vector<std::array<double, 2>> extents;
    for (std::uint32_t p = 0; p < sections.patches(); ++p) extents.push_back(sections.extent(p, normal_));
    place_planes(extents);
    sort_patches(extents);
  }

  std::size_t planes() const { return planes_.size(); }

  /// Marks the patches that one of the planes cuts.
  void mark_cut(std::vector<std::uint8_t>& patches) const {
    for (std::size_t plane = 0; plane < planes_.size(); ++plane)
      for (std::uint32_t i = start_[plane]; i < start_[plane + 1]; ++i)
        if (cuts(plane, patches_[i])) patches[patches_[i]] = 1;
  }

  /// The slices of one plane. `obstacles`: of all patches that are marked.
  std::vector<ClSlice> cut(std::size_t plane, const PatchObstacles& obstacles) const {
    std::vector<ClStrand> strands, kept;
    for (std::uint32_t i = start_[plane]; i < start_[plane + 1]; ++i) {
      const std::uint32_t patch = patches_[i];
      if (!cuts(plane, patch)) continue;
      strands.clear();
      sections_.cut(patch, normal_, planes_[plane].height, strands);
      for (const ClStrand& strand : strands)
        trim_strand(strand, tree_, obstacles.of(patch), sections_.radius(), kept);
    }
    const JoinLimits limits{budget_.gaps(), kWideGap, budget_.gaps(), kShortestChain};
    std::vector<ClSlice> slices;
    for (ClChain& chain : join_strands(std::move(kept), tree_, sections_.radius(), limits)) {
      for (ClChain& run : wanted(std::move(chain), planes_[plane].level)) {
        thin_chain(run, budget_.free_thinning());
        slices.push_back({index_, planes_[plane].height, static_cast<std::uint32_t>(plane), std::move(run)});
      }
    }
    return slices;
  }

 private:
  void place_planes(const std::vector<std::array<double, 2>>& extents) {
    double low = 1e300, high = -1e300;
    for (const auto& [a, b] : extents) low = std::min(low, a), high = std::max(high, b);
    const auto count = static_cast<int>(std::floor((high - low) / step_));
    const double first = (low + high - count * step_) / 2.0;
    for (int i = 0; i <= count; ++i) planes_.push_back({first + i * step_, 0});
    const int levels = options_.pattern.measure == StepMeasure::kFlat ? 0 : kMostLevels;
    for (int level = 1; level <= levels; ++level) {
      const double half = step_ / (1 << level);
      for (double h = first - half; h > low; h -= 2.0 * half) planes_.push_back({h, level});
      for (double h = first + half; h < high; h += 2.0 * half) planes_.push_back({h, level});
    }
    std::sort(planes_.begin(), planes_.end(),
              [](const Plane& a, const Plane& b) { return a.height < b.height; });
  }

  /// Which patches each plane meets, of those that may matter to the stack.
  void sort_patches(const std::vector<std::array<double, 2>>& extents) {
    const auto needed = stack_share(sections_, index_, options_, kShortestRun * step_);
    const auto range = [&](std::uint32_t patch) {
      const auto [low, high] = extents[patch];
      const auto below = [](const Plane& p, double h) { return p.height < h; };
      if (needed[patch] == 0) return std::array<std::ptrdiff_t, 2>{0, 0};
      // A face is cut where one of its corners lies under the plane and another on it or above.
      const auto at_or_below = [](double h, const Plane& p) { return h < p.height; };
      if (sections_.is_face(patch))
        return std::array<std::ptrdiff_t, 2>{
            std::upper_bound(planes_.begin(), planes_.end(), low, at_or_below) - planes_.begin(),
            std::upper_bound(planes_.begin(), planes_.end(), high, at_or_below) - planes_.begin()};
      return std::array<std::ptrdiff_t, 2>{
          std::lower_bound(planes_.begin(), planes_.end(), low, below) - planes_.begin(),
          std::lower_bound(planes_.begin(), planes_.end(), high, below) - planes_.begin()};
    };
    start_.assign(planes_.size() + 1, 0);
    for (std::uint32_t p = 0; p < sections_.patches(); ++p) {
      const auto [first, last] = range(p);
      for (auto i = first; i < last; ++i) ++start_[static_cast<std::size_t>(i) + 1];
    }
    for (std::size_t i = 0; i < planes_.size(); ++i) start_[i + 1] += start_[i];
    patches_.resize(start_.back());
    std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
    for (std::uint32_t p = 0; p < sections_.patches(); ++p) {
      const auto [first, last] = range(p);
      for (auto i = first; i < last; ++i) patches_[next[static_cast<std::size_t>(i)]++] = p;
    }
  }

  bool cuts(std::size_t plane, std::uint32_t patch) const {
    return !sections_.is_face(patch) || needs(sections_.normals(patch).axis, planes_[plane].level);
  }

  /// (N8) Are the planes of the levels below too far apart there? The surface may lean further before the
  /// next plane, the more the flatter it lies.
  bool needs(Vec3 n, int level) const {
    if (level == 0) return true;
    const double lean = dot(n, normal_), sine = std::sqrt(std::max(0.0, 1.0 - lean * lean));
    return 1.0 / (1 << (level - 1)) > sine;
  }
  bool inside(Point<Part> p) const {
    const Containment& c = options_.containment;
    return c.first.contains(p.x) && c.second.contains(p.y) && c.height.contains(p.z);
  }

  /// Points more where the chain crosses the containment's borders.
  ClStrand cut_at_borders(const ClStrand& strand) const {
    const Containment& c = options_.containment;
    if (!c.first.bounded() && !c.second.bounded() && !c.height.bounded()) return strand;
    ClStrand result{strand.front()};
    std::vector<double> crossings;
    for (std::size_t i = 1; i < strand.size(); ++i) {
      const ClPoint &a = strand[i - 1], &b = strand[i];
      crossings.clear();
      const auto cross_at = [&](double from, double to, double border) {
        if (std::isfinite(border) && (from < border) != (to < border))
          crossings.push_back((border - from) / (to - from));
      };
      cross_at(a.centre.x, b.centre.x, c.first.low), cross_at(a.centre.x, b.centre.x, c.first.high);
      cross_at(a.centre.y, b.centre.y, c.second.low), cross_at(a.centre.y, b.centre.y, c.second.high);
      cross_at(a.centre.z, b.centre.z, c.height.low), cross_at(a.centre.z, b.centre.z, c.height.high);
      std::sort(crossings.begin(), crossings.end());
      for (const double f : crossings)
        result.push_back(
            {lerp(a.centre, b.centre, f), normalized(a.normal * (1.0 - f) + b.normal * f), a.facet});
      result.push_back(b);
    }
    return result;
  }

  /// The runs of a chain that this plane is to cut.
  std::vector<ClChain> wanted(ClChain chain, int level) const {
    chain.points = cut_at_borders(chain.points);
    const ClStrand& p = chain.points;
    const std::size_t moves = p.size() - 1;
    std::vector<std::uint8_t> cut(moves), allowed(moves);
    for (std::size_t i = 0; i < moves; ++i) {
      const Vec3 sum = p[i].normal + p[i + 1].normal;
      const Vec3 n = squared_length(sum) > 0.0 ? normalized(sum) : p[i].normal;
      allowed[i] = inside(lerp(p[i].centre, p[i + 1].centre, 0.5));
      cut[i] = allowed[i] != 0 && owned_by(index_, n, options_) && needs(n, level);
    }
    swallow(p, cut, 0);  // short gaps are closed
    for (std::size_t i = 0; i < moves; ++i) cut[i] &= allowed[i];
    if (level == 0) swallow(p, cut, 1);  // short runs are left to another stack
    std::vector<ClChain> runs;
    for (std::size_t i = 0; i < moves; ++i) {
      if (cut[i] == 0) continue;
      if (i == 0 || cut[i - 1] == 0) runs.push_back({{p[i]}, false});
      runs.back().points.push_back(p[i + 1]);
    }
    if (chain.closed && !runs.empty() && cut.front() != 0 && cut.back() != 0) {
      if (runs.size() == 1) {
        runs[0].closed = true;
      } else {  // one run over the place where the chain was closed
        ClStrand& last = runs.back().points;
        last.insert(last.end(), runs[0].points.begin() + 1, runs[0].points.end());
        runs.erase(runs.begin());
      }
    }
    return runs;
  }

  /// Turns over the runs of moves that have `value`, lie between others and are short.
  void swallow(const ClStrand& p, std::vector<std::uint8_t>& cut, std::uint8_t value) const {
    for (std::size_t i = 0; i < cut.size();) {
      std::size_t end = i;
      double length = 0.0;
      for (; end < cut.size() && cut[end] == cut[i]; ++end)
        length += distance(p[end].centre, p[end + 1].centre);
      if (cut[i] == value && i > 0 && end < cut.size() && length < kShortestRun * step_)
        std::fill(cut.begin() + static_cast<std::ptrdiff_t>(i),
                  cut.begin() + static_cast<std::ptrdiff_t>(end), static_cast<std::uint8_t>(1 - value));
      i = end;
    }
  }

  const ClSections& sections_;
  const FacetBvh& tree_;
  const PlanOptions& options_;
  std::uint32_t index_;
  Vec3 normal_;
  double step_;
  ToleranceBudget budget_;
  std::vector<Plane> planes_;
  std::vector<std::uint32_t> start_, patches_;  ///< patches of each plane
};

}  // namespace

std::vector<ClSlice> slice_cl_surface(const CheckedMesh& part, const FacetBvh& tree,
                                      const PlanOptions& options, const ToleranceBudget& budget,
                                      const std::function<bool(double)>& go_on) {
  const ClSections sections(part, options.cutter.radius() + options.allowance, budget.chords());
  const auto count = static_cast<std::uint32_t>(options.free.plane_normals.size());
  std::vector<Stack> stacks;
  std::vector<std::uint8_t> is_cut(sections.patches(), 0);
  for (std::uint32_t s = 0; s < count; ++s) {
    stacks.emplace_back(sections, tree, options, s, budget);
    stacks.back().mark_cut(is_cut);
  }
  const PatchObstacles obstacles(sections, tree, is_cut);
  std::vector<ClSlice> slices;
  for (std::uint32_t s = 0; s < count; ++s) {
    std::vector<std::vector<ClSlice>> cut(stacks[s].planes());
    const ReportShare report = part_of(go_on, static_cast<double>(s) / count, (s + 1.0) / count);
    Watch watch(report, cut.size());
    for (std::size_t first = 0; first < cut.size(); first += kPlanesPerTurn) {
      if (watch.stopped()) return {};
      tbb::parallel_for(
          first, std::min(cut.size(), first + kPlanesPerTurn),
          [&](std::size_t plane) {
            if (watch.next()) cut[plane] = stacks[s].cut(plane, obstacles);
          },
          tbb::simple_partitioner());
    }
    if (watch.stopped()) return {};
    for (auto& plane : cut)
      for (ClSlice& slice : plane) slices.push_back(std::move(slice));
  }
  return slices;
}

}  // namespace tiltfeed::pathgen
