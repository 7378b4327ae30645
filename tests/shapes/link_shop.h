#pragma once
// Parts, their passes and everything else that the links are made from, the planner's way; and what a linked
// path is held to.

#include <algorithm>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pathgen/envelope/thinning.h"
#include "pathgen/linking/linking.h"
#include "pathgen/linking/travel.h"
#include "tests/judges/path_proof.h"

namespace tiltfeed {
using namespace pathgen;

inline constexpr double kTolerance = 0.01, kRadius = 2.0, kClearance = 6.0;

inline const AxisFrame kFixedFrame{AxisMode::kFixed, Sense::kOutward, {0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 0.0};

/// A sheet of cells over the flat space, wound round the axis feature; `height` gives z' of a corner,
/// `there` whether a cell is. Open, so both sides count.
template <class Height, class There>
CheckedMesh sheet(const AxisFrame& frame, double rho, Point<Flat> low, Point<Flat> high, int columns,
                  int rows, Height height, There there) {
  CheckedMesh part;
  const Deformation map(frame, rho);
  for (int i = 0; i <= columns; ++i)
    for (int j = 0; j <= rows; ++j) {
      Point<Flat> f{low.x + (high.x - low.x) * i / columns, low.y + (high.y - low.y) * j / rows, 0.0};
      f.z = height(f.x, f.y);
      part.mesh.vertices.push_back(map.unflatten(f));
    }
  const auto id = [&](int i, int j) { return static_cast<std::uint32_t>(i * (rows + 1) + j); };
  for (int i = 0; i < columns; ++i)
    for (int j = 0; j < rows; ++j) {
      if (!there(i, j)) continue;
      part.mesh.facets.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      part.mesh.facets.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  for (std::uint32_t f = 0; f < part.mesh.facets.size(); ++f) part.mesh.source.push_back(f);
  part.sides = Sides::kBoth;
  const Point<Part> first = part.mesh.vertices.front();
  part.bounds.min = part.bounds.max = first;
  for (const Point<Part> v : part.mesh.vertices) {
    part.bounds.min = {std::min(part.bounds.min.x, v.x), std::min(part.bounds.min.y, v.y),
                       std::min(part.bounds.min.z, v.z)};
    part.bounds.max = {std::max(part.bounds.max.x, v.x), std::max(part.bounds.max.y, v.y),
                       std::max(part.bounds.max.z, v.z)};
  }
  return part;
}

/// Everything that link() asks for, made the planner's way.
struct Shop {
  CheckedMesh part;
  PlanOptions options;
  Linking links;
  std::unique_ptr<const ClField> field;
  EnvelopeOptions limits{kTolerance / 4.0, 0.025};
  std::vector<std::vector<Pass>> slices;
  std::unique_ptr<OppositeWall> opposite_wall;
  std::unique_ptr<Envelope> envelope;

  Shop(CheckedMesh made, const AxisFrame& frame, double side_step, double shank = 30.0,
       const std::function<bool(const EnvelopePoint&)>& unwanted = {}, Vec3 up = {0, 0, 1},
       double tilt_max = 180.0, Along along = Along::kX)
      : part(std::move(made)) {
    options.cutter = {2.0 * kRadius, 100.0, shank};
    options.axis = frame;
    options.tolerance = kTolerance;
    options.pattern.side_step = side_step;
    std::vector<std::string> warnings;
    auto found = make_field(part, options, warnings);
    if (!found) throw std::runtime_error(found.error().message);
    field = std::move(*found);
    envelope = std::make_unique<Envelope>(field->surface, field->deformation, field->index, limits);
    links.tilt_max = Angle::from_degrees(tilt_max), links.up = up;
    double top = -1e9;
    for (const FlatLine& line : lines(along, side_step)) {
      std::vector<Pass> passes = envelope->along(line).passes;
      for (const Pass& pass : passes)
        for (const EnvelopePoint& p : pass) top = std::max(top, p.flat.z);
      leave_out(passes, [&](const EnvelopePoint& p) {
        return (unwanted && unwanted(p)) || angle_between(p.axis, up) > links.tilt_max.radians();
      });
      slices.emplace_back();
      for (const Pass& pass : passes) slices.back().push_back(thinned(pass, limits.tolerance, limits));
    }
    if (field->deformation.s() > 0.0)
      for (const Point<Part> v : part.mesh.vertices)
        top = std::max(top, field->deformation.flatten(v).z + kRadius);
    links.reference_height = kRadius;
    links.clearance_z = top + kClearance;
    links.clearance = kClearance;
    links.approach = 1.0;
    links.thinning = limits.tolerance;
    links.plunge_ratio = 3.0;
    opposite_wall = std::make_unique<OppositeWall>(part.mesh, field->deformation, options, links.clearance_z);
    opposite_wall->trim(slices);
  }

  /// Straight lines side by side over the part.
  std::vector<FlatLine> lines(Along along, double step) const {
    const FlatBounds& b = field->index.bounds();
    const double x = b.max_x - b.min_x, y = b.max_y - b.min_y;
    std::vector<FlatLine> found;
    for (double at = step / 2.0; at < (along == Along::kX ? y : x); at += step)
      found.push_back(along == Along::kX ? FlatLine{b.min_x, b.min_y + at, 1.0, 0.0, x}
                                         : FlatLine{b.min_x + at, b.min_y, 0.0, 1.0, y});
    return found;
  }
  Linked run() { return link(slices, *field, links, *opposite_wall, *envelope); }
  Travel travel() { return {field->deformation, links, *opposite_wall}; }
  std::size_t passes() const {
    std::size_t count = 0;
    for (const auto& slice : slices) count += slice.size();
    return count;
  }
};

/// A tube round the whole ring, or a shell round the point or line.
inline CheckedMesh whole(const AxisFrame& frame, double rho) {
  const Deformation map(frame, rho);
  const double x = frame.mode == AxisMode::kLine ? 20.0 : kPi * map.scale_x();
  const double y = frame.mode == AxisMode::kPoint ? 0.49 * kPi * rho : kPi * rho;
  return sheet(
      frame, rho, {-x, -y, 0}, {x, y, 0}, 60, 24, [&](double, double) { return map.s() * rho; },
      [](int, int) { return true; });
}

inline Measured proof(const Shop& shop, const Linked& linked) {
  ToolPath path;
  path.moves = linked.moves;
  const PathProof proof(shop.options.axis, Along::kX, shop.options.cutter, kTolerance, shop.part, path);
  return proof.measure(4 * linked.moves.size());
}

inline void expect_proven(const Shop& shop, const Linked& linked) {
  const Measured m = proof(shop, linked);
  EXPECT_LE(m.gouge, kTolerance) << pasteable(m.gouge_at);
  EXPECT_LE(m.contact, kTolerance) << pasteable(m.contact_at);
  EXPECT_LE(m.rapid_overlap, kTolerance / 2.0) << pasteable(m.rapid_at);
}

/// Length of the tip's way over all that does not cut.
inline double air_of(const Linked& linked) {
  double air = 0.0;
  for (std::size_t i = 1; i < linked.moves.size(); ++i)
    if (linked.moves[i].kind != MoveKind::kCut)
      air += distance(linked.moves[i - 1].pose.tip, linked.moves[i].pose.tip);
  return air;
}

/// How often a rapid is followed by something else.
inline std::size_t descents(const Linked& linked) {
  std::size_t count = 0;
  for (std::size_t i = 1; i < linked.moves.size(); ++i)
    count += linked.moves[i - 1].kind == MoveKind::kRapid && linked.moves[i].kind != MoveKind::kRapid;
  return count;
}

inline double widest_tilt(const Linked& linked, Vec3 up) {
  double widest = 0.0;
  for (std::size_t i = 1; i < linked.moves.size(); ++i) {
    if (linked.moves[i].kind == MoveKind::kCut) continue;
    for (double f : {0.0, 0.2, 0.4, 0.5, 0.6, 0.8, 1.0})
      widest = std::max(
          widest, angle_between(slerp(linked.moves[i - 1].pose.axis, linked.moves[i].pose.axis, f), up));
  }
  return widest;
}

}  // namespace tiltfeed
