#include "sim/engagement/chip_gauge.h"

#include <algorithm>
#include <cmath>

#include "sim/removal/dexel_units.h"
#include "sim/removal/tool_sweep.h"

namespace tiltfeed::sim {
namespace {

// Halvings of a span until the place where a piece is met is known to 1e-4 of it.
constexpr int kHalvings = 14;
// A surface that goes along the feed all but exactly counts as so much ahead of it, as a sine.
constexpr double kGrazing = 0.02;
// Next to the axis the radius counts as this share of a cell at least.
constexpr double kLeastRadius = 0.25;
// A line that grazes the surface stands for so much of it as one that is this square to it.
constexpr double kLeastSquare = 0.3;
constexpr int kMostChunks = 256;
constexpr double kColumnAngle = 2.0 * kPi / kColumns;

std::int64_t whole(double value, double unit) { return std::llround(value / unit); }

}  // namespace

void ColumnSum::add(const ColumnSum& more) {
  volume += more.volume, load += more.load, turn += more.turn, chip += more.chip;
}

ChipGauge::ChipGauge(const Revolved& cutting, const EngagedSpan& span, double cell, double bin, double chunk)
    : cutting_(cutting),
      from_(span.from),
      axis_(mean_axis(span.from, span.to)),
      way_(span.to.tip - span.from.tip),
      turn_(span.to.axis - span.from.axis),
      per_minute_(span.asked > 0.0 ? 60.0 / span.asked : 0.0),
      cell_(cell),
      bin_(bin),
      chunk_(chunk) {
  const auto across = [&](Vec3 v) { return v - axis_ * dot(v, axis_); };
  const Vec3 moved = squared_length(way_) > 0.0 ? way_ : turn_;
  ahead_ = across(moved);
  // Along the axis no direction is ahead: any will do.
  if (length(ahead_) <= 1e-6 * length(moved))
    ahead_ = across(std::abs(axis_.x) < 0.8 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0});
  ahead_ = normalized(ahead_);
  left_ = cross(axis_, ahead_);
}

/// How far p is from the cutting part at a share of the span; below 0: inside.
double ChipGauge::depth(Point<Part> p, double share) const {
  const Vec3 from = p - (from_.tip + way_ * share), axis = from_.axis + turn_ * share;
  const double h = dot(from, axis);
  return cutting_.distance(length(from - axis * h), h).value;
}

ChipGauge::Contact ChipGauge::stand(Point<Part> p, double share, double& depth) const {
  const Vec3 from = p - (from_.tip + way_ * share), axis = from_.axis + turn_ * share;
  const double h = dot(from, axis);
  const Vec3 off = from - axis * h;
  const double r = length(off);
  const Vec3 out = r > 0.0 ? off * (1.0 / r) : ahead_;
  const Slope slope = cutting_.distance(r, h);
  depth = slope.value;
  const Vec3 normal = out * slope.along_r + axis * slope.along_h;
  return {r, h, squared_length(normal) > 0.0 ? normalized(normal) : out, out};
}

/// (CH1) Where the cutter's surface meets p first.
ChipGauge::Contact ChipGauge::contact(Point<Part> p) const {
  double low = 0.0, high = 1.0, there = 0.0;
  if (depth(p, 0.0) <= 0.0) return stand(p, 0.0, there);
  if (depth(p, 1.0) > 0.0) {
    // It passes by: the distance is convex over the span.
    double a = 0.0, b = 1.0;
    for (int i = 0; i < kHalvings; ++i) {
      const double one = a + (b - a) / 3.0, two = b - (b - a) / 3.0;
      if (depth(p, one) < depth(p, two))
        b = two;
      else
        a = one;
    }
    high = 0.5 * (a + b);
    if (depth(p, high) > 0.0) return stand(p, high, there);
  }
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (depth(p, middle) > 0.0 ? low : high) = middle;
  }
  return stand(p, low, there);
}

void ChipGauge::add(Point<Part> p, double length, int axis, SpanSum& sum) const {
  const Contact c = contact(p);
  const double along = component(c.normal, axis);
  // (CH2) Of what three bundles remove each counts by the share of its direction in the normal.
  const double volume = length * along * along * cell_ * cell_;
  const Vec3 moved = way_ + turn_ * c.height;
  const double ahead = std::max(dot(c.normal, moved), kGrazing * tiltfeed::length(moved));
  if (!(volume > 0.0) || !(ahead > 0.0)) return;
  const double angle = std::atan2(dot(c.out, left_), dot(c.out, ahead_));
  const double radius = std::max(c.radius, kLeastRadius * cell_);
  const double chip = ahead * per_minute_, force = std::pow(chip, kChipExponent) * volume / ahead;
  // A line stands for a cell of the surface: so far round the axis, and all round next to it.
  const double wide = std::min(kPi, cell_ / (radius * std::max(std::abs(along), kLeastSquare)));
  const double first = (angle + kPi - 0.5 * wide) / kColumnAngle, last = first + wide / kColumnAngle;
  for (int column = static_cast<int>(std::floor(first)); column < last; ++column) {
    const double share = (std::min(column + 1.0, last) - std::max(1.0 * column, first)) / (last - first);
    sum.columns[(column + kColumns) % kColumns].add(
        {whole(volume * share, kSumUnit), whole(force * share / (radius * kColumnAngle), kSumUnit),
         whole(force * share / (2.0 * kPi), kSumUnit), whole(volume * chip * share, kChipUnit)});
  }
  sum.heights |= std::uint64_t{1} << std::clamp(static_cast<int>(c.height / bin_), 0, kHeights - 1);
}

void ChipGauge::take(const Removed& piece, int axis, SpanSum& sum) const {
  const double length = piece.high - piece.low;
  const int count = static_cast<int>(std::clamp(std::ceil(length / chunk_), 1.0, 1.0 * kMostChunks));
  for (int i = 0; i < count; ++i) {
    const double at = piece.low + length * (i + 0.5) / count;
    Point<Part> p = piece.origin;
    (axis == 0 ? p.x : axis == 1 ? p.y : p.z) = at;
    add(p, length / count, axis, sum);
  }
}

}  // namespace tiltfeed::sim
