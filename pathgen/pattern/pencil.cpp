#include "pathgen/pattern/pencil.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "pathgen/envelope/thinning.h"
#include "pathgen/pattern/region_pattern.h"

namespace tiltfeed::pathgen {

namespace {

/// Of the envelope's tolerance: how far a piece of a crease may be off it, and, in such lengths, how far
/// beside it a pass goes where one side is steep.
constexpr double kChordShare = 0.5, kAsideChords = 2.0;
/// Of the envelope's tolerance: a lower step of the CL surface is none, and ends of creases so near are one.
constexpr double kCliffTolerances = 5.0, kGapTolerances = 5.0;
/// Of the diameter: what rises so far over the crease has climbed the wall beside it.
constexpr double kClimbShare = 0.05;
/// Ends of two pieces nearer than this are one place, mm.
constexpr double kSamePlace = 1e-6;
constexpr std::size_t kCreasesPerReport = 64;

/// The crease, moved aside where it runs along something steep, without places nearer than that.
struct Course {
  FlatCurve curve;
  std::vector<double> heights;  ///< z' of the crease at each place
};

Course course_of(const Crease& crease, double aside) {
  Course course;
  for (std::size_t i = 0; i < crease.size(); ++i) {
    const CreaseNode& node = crease[i];
    Place place{node.point.flat.x, node.point.flat.y};
    if (node.steep) {
      const Point<Flat> from = crease[i == 0 ? 0 : i - 1].point.flat,
                        to = crease[std::min(i + 1, crease.size() - 1)].point.flat;
      const double dx = to.x - from.x, dy = to.y - from.y, along = std::hypot(dx, dy);
      double across_x = node.aside[0], across_y = node.aside[1];
      if (along > 0.0) {
        const double sign = across_y * dx - across_x * dy >= 0.0 ? 1.0 : -1.0;
        across_x = -sign * dy / along, across_y = sign * dx / along;
      }
      place.x += aside * across_x, place.y += aside * across_y;
    }
    const bool ends = i == 0 || i + 1 == crease.size();
    if (!ends && distance(place, course.curve.back()) < aside) continue;
    course.curve.push_back(place), course.heights.push_back(node.point.flat.z);
  }
  return course;
}

/// The envelope over the course, without what has climbed a wall.
std::vector<Pass> lay_course(const Course& course, double climb, Heights& heights) {
  std::vector<Pass> laid;
  for (std::size_t i = 0; i + 1 < course.curve.size(); ++i) {
    std::vector<Pass> pieces = lay_curve({course.curve[i], course.curve[i + 1]}, heights);
    const double most = std::max(course.heights[i], course.heights[i + 1]) + climb;
    leave_out(pieces, [&](const EnvelopePoint& p) { return p.flat.z > most; });
    for (Pass& piece : pieces) {
      const bool on = !laid.empty() && distance(laid.back().back().centre, piece.front().centre) < kSamePlace;
      if (!on) laid.emplace_back();
      laid.back().insert(laid.back().end(), piece.begin() + (on ? 1 : 0), piece.end());
    }
  }
  std::erase_if(laid, [](const Pass& pass) { return pass.size() < 2; });
  return laid;
}

/// From each pass to the nearest end of those that are left.
void order_by_nearest(std::vector<std::vector<Pass>>& groups) {
  for (std::size_t k = 1; k < groups.size(); ++k) {
    const Point<Part> at = groups[k - 1].back().back().centre;
    const auto ahead = [&](const std::vector<Pass>& g) { return distance(g.front().front().centre, at); };
    const auto behind = [&](const std::vector<Pass>& g) { return distance(g.back().back().centre, at); };
    const auto nearest = std::min_element(
        groups.begin() + static_cast<std::ptrdiff_t>(k), groups.end(), [&](const auto& g, const auto& h) {
          return std::min(ahead(g), behind(g)) < std::min(ahead(h), behind(h));
        });
    if (behind(*nearest) < ahead(*nearest)) {
      std::reverse(nearest->begin(), nearest->end());
      for (Pass& pass : *nearest) std::reverse(pass.begin(), pass.end());
    }
    std::swap(groups[k], *nearest);
  }
}

}  // namespace

Result<Contours> pencil(const ClField& field, const FlatBounds& bounds, const ContourOptions& options,
                        double diameter, double thinning, const Progress& progress) {
  const double tolerance = options.envelope.tolerance;
  CreaseOptions how;
  how.envelope = options.envelope;
  how.kinks = {options.pattern.crease_angle, kCliffTolerances * tolerance};
  how.spacing = kPencilSpacing * diameter;
  const Deformation::Stretch most = field.deformation.stretch(field.index.furthest());
  how.chord = kChordShare * tolerance;
  const auto graph = trace_crease_graph(field, bounds, how, progress);
  if (!graph) return tl::unexpected(graph.error());
  const std::vector<Crease> creases =
      joined_creases(*graph, kGapTolerances * tolerance, kPencilLength * diameter);
  std::vector<std::vector<Pass>> laid(creases.size());
  tbb::enumerable_thread_specific<Heights> heights([&] { return Heights(field, options.envelope); });
  const double aside = kAsideChords * how.chord / std::max(most.x, most.y);
  for (std::size_t from = 0; from < creases.size(); from += kCreasesPerReport) {
    const std::size_t to = std::min(from + kCreasesPerReport, creases.size());
    tbb::parallel_for(from, to, [&](std::size_t k) {
      laid[k] = lay_course(course_of(creases[k], aside), kClimbShare * diameter, heights.local());
      for (Pass& pass : laid[k]) pass = thinned(pass, thinning, options.envelope);
    });
    if (progress && !progress("laid", static_cast<double>(to) / static_cast<double>(creases.size())))
      return cancelled();
  }
  std::erase_if(laid, [](const std::vector<Pass>& passes) { return passes.empty(); });
  if (laid.empty())
    return fail(
        Code::kUnreachable,
        "no crease: nowhere does the tool touch the part at two places whose normals differ by " +
            std::to_string(options.pattern.crease_angle.degrees()) +
            " degrees or more; use a smaller pattern.crease_angle_deg, a larger cutter, or leave this "
            "operation out");
  order_by_nearest(laid);
  Contours result;
  result.groups = std::move(laid);
  return result;
}

}  // namespace tiltfeed::pathgen
