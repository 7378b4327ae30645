// Pull handle: a superellipse swept along a U in the plane y = 0, feet at z = 0. A station is a place on the
// centre line, from the left foot up, over and down; a section's normal lies in the plane y = 0 and points
// out of the U, so that (normal, y, tangent) is left-handed: around goes from the normal towards -y.

#include <algorithm>
#include <cassert>
#include <cmath>

#include "kinematics/basics/units.h"
#include "sim/parts/facet_mesh.h"

namespace tiltfeed::sim {
namespace {

constexpr std::size_t kHandleFacets = 23'780;
constexpr int kAround = 82;      ///< columns
constexpr int kIntervals = 128;  ///< along the centre line
constexpr int kFootRings = 8;    ///< on a foot's flat face, between its centre and its rim

constexpr double kHalfSpan = 55.0, kRise = 36.0, kCorner = 22.0;
constexpr double kLeg = kRise - kCorner;
constexpr double kArc = 0.5 * kPi * kCorner;
constexpr double kHalfLength = kLeg + kArc + (kHalfSpan - kCorner);

// Half axes of the section, in the plane of the U and across it: a bell over the middle on a constant bar.
constexpr double kBarIn = 7.6, kSwellIn = 1.6, kSwellLengthIn = 34.0;
constexpr double kBarAcross = 9.4, kSwellAcross = 2.2, kSwellLengthAcross = 38.0;
constexpr double kFootRadius = 15.0, kFlareLength = 3.5;
constexpr double kExponent = 2.6, kRoundExponent = 2.0;
constexpr double kGrooveDepth = 2.0, kGroovePitch = 16.0, kGrooveEnd = 32.0;
constexpr double kRestDepth = 1.1, kRestLength = 12.0;

struct Section {
  Vec3 centre, normal;
  double in = 0.0, across = 0.0;
  double exponent = kRoundExponent;
  double groove = 0.0, rest = 0.0;  ///< how deep, below and on top
};

double bell(double x, double length) { return std::exp(-(x / length) * (x / length)); }

/// `s`: along the centre line, 0 in the middle of the grip, negative to the left.
void place_on_centre_line(double s, Section& section) {
  const double side = s < 0.0 ? -1.0 : 1.0;
  const double along = std::abs(s);
  const double straight = kHalfSpan - kCorner;
  if (along <= straight) {
    section.centre = {s, 0.0, kRise};
    section.normal = {0.0, 0.0, 1.0};
  } else if (along < straight + kArc) {
    const double turn = (along - straight) / kCorner;
    section.normal = {side * std::sin(turn), 0.0, std::cos(turn)};
    section.centre = Vec3{side * straight, 0.0, kLeg} + kCorner * section.normal;
  } else {
    section.normal = {side, 0.0, 0.0};
    section.centre = {side * kHalfSpan, 0.0, std::max(0.0, kHalfLength - along)};
  }
}

Section section_at(double s) {
  Section section;
  place_on_centre_line(s, section);
  const double along = std::abs(s);
  const double flare = std::exp(-(kHalfLength - along) / kFlareLength);
  const double in = kBarIn + kSwellIn * bell(s, kSwellLengthIn);
  const double across = kBarAcross + kSwellAcross * bell(s, kSwellLengthAcross);
  section.in = in + (kFootRadius - in) * flare;
  section.across = across + (kFootRadius - across) * flare;
  section.exponent = kExponent + (kRoundExponent - kExponent) * flare;
  if (along < kGrooveEnd) {
    const double wave = std::sin(kPi * along / kGroovePitch);
    section.groove = kGrooveDepth * wave * wave;
  }
  section.rest = kRestDepth * bell(s, kRestLength);
  return section;
}

Vec3 section_point(const Section& section, int column) {
  const double angle = 2.0 * kPi * column / kAround;
  const double c = std::cos(angle), s = std::sin(angle);
  const double p = section.exponent;
  const double reach = std::pow(std::pow(std::abs(c), p) + std::pow(std::abs(s), p), -1.0 / p);
  const double cut = c * c * (c > 0.0 ? section.rest : section.groove);
  const double up = (section.in * c - (c > 0.0 ? cut : -cut)) * reach;
  return section.centre + up * section.normal + Vec3{0.0, -section.across * s * reach, 0.0};
}

}  // namespace

Triangles handle() {
  FacetMesh mesh;
  std::vector<std::array<std::uint32_t, kAround>> rings;
  const auto add_foot_ring = [&](double side, int ring) {
    Section section;
    place_on_centre_line(side * kHalfLength, section);
    section.in = section.across = kFootRadius * ring / (kFootRings + 1);
    for (int column = 0; column < kAround; ++column)
      rings.back()[column] = add_vertex(mesh, section_point(section, column));
  };
  const std::uint32_t first_centre = add_vertex(mesh, {-kHalfSpan, 0.0, 0.0});
  for (int ring = 1; ring <= kFootRings; ++ring) {
    rings.emplace_back();
    add_foot_ring(-1.0, ring);
  }
  for (int station = 0; station <= kIntervals; ++station) {
    const Section section = section_at(kHalfLength * (2.0 * station / kIntervals - 1.0));
    rings.emplace_back();
    for (int column = 0; column < kAround; ++column)
      rings.back()[column] = add_vertex(mesh, section_point(section, column));
  }
  for (int ring = kFootRings; ring >= 1; --ring) {
    rings.emplace_back();
    add_foot_ring(1.0, ring);
  }
  const std::uint32_t last_centre = add_vertex(mesh, {kHalfSpan, 0.0, 0.0});

  for (int column = 0; column < kAround; ++column) {
    const int next = (column + 1) % kAround;
    mesh.facets.push_back({first_centre, rings.front()[next], rings.front()[column]});
    for (std::size_t ring = 0; ring + 1 < rings.size(); ++ring)
      add_quad(mesh, rings[ring][column], rings[ring][next], rings[ring + 1][next], rings[ring + 1][column]);
    mesh.facets.push_back({last_centre, rings.back()[column], rings.back()[next]});
  }
  assert(mesh.facets.size() == kHandleFacets);
  return to_triangles(mesh);
}

}  // namespace tiltfeed::sim
