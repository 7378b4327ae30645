// Tyre-mould segment, meshed as a block of which only the skin is made: line i counts along Theta, j (or
// m) along Phi and k from the cavity, a height field over the torus, to the back.
// Frame: centre circle in the plane y = 0 about the origin, segment around -z; Theta from -z towards +x, Phi
// from the plane towards +y, rho the distance from the circle; a rib of height h reaches in to rho = 90 - h.

#include <algorithm>
#include <cassert>
#include <cmath>
#include <map>
#include <utility>

#include "sim/parts/facet_mesh.h"
#include "sim/parts/tyre_tread.h"

namespace tiltfeed::sim {
namespace {

constexpr double kBackRadius = 410.0;
constexpr int kLayers = 58;  ///< K
/// Layer 1 is a surface just behind the ribs' feet: it keeps the sector faces' cells from folding at the
/// ribs.
constexpr double kSkirtDepth = 1.4;
constexpr double kSkirtStraight = 44.0;  ///< degrees of Phi; the skirt lies behind along rho up to here, then
                                         ///< turns to run along the top and bottom at the edge
constexpr double kWallStep = 1.5;        ///< mm of height: walls are cut into rows at most this high
constexpr double kSameHeight = 1e-6;     ///< mm: levels of the tread differ by 1 mm or more

/// Polar coordinates about y; theta in degrees.
struct Polar {
  double theta = 0.0, radius = 0.0, y = 0.0;
};
Polar between(Polar a, Polar b, double f) {
  return {a.theta + (b.theta - a.theta) * f, a.radius + (b.radius - a.radius) * f, a.y + (b.y - a.y) * f};
}
Vec3 to_part(Polar p) {
  return {p.radius * std::sin(p.theta * kDegree), p.y, -p.radius * std::cos(p.theta * kDegree)};
}

/// A point of the cavity: degrees, and the height of its rib in mm.
struct CavityPoint {
  double theta = 0.0, phi = 0.0, height = 0.0;
};
CavityPoint between(CavityPoint a, CavityPoint b, double f) {
  return {a.theta + (b.theta - a.theta) * f, a.phi + (b.phi - a.phi) * f,
          a.height + (b.height - a.height) * f};
}
Polar to_polar(CavityPoint p) {
  const double rho = kSectionRadius - p.height;
  return {p.theta, kCircleRadius + rho * std::cos(p.phi * kDegree), rho * std::sin(p.phi * kDegree)};
}

Polar skirt(double theta, double phi) {
  const double side = std::abs(phi);
  const double turned =
      side <= kSkirtStraight ? phi : phi / side * kSkirtStraight * (kPhi - side) / (kPhi - kSkirtStraight);
  const Polar foot = to_polar(CavityPoint{theta, phi, 0.0});
  return {theta, foot.radius + kSkirtDepth * std::cos(turned * kDegree),
          foot.y + kSkirtDepth * std::sin(turned * kDegree)};
}

using Chain = std::vector<std::uint32_t>;

class Tyre {
 public:
  FacetMesh build(std::size_t facets) && {
    add_nodes();
    add_cavity_and_back();
    add_top_and_bottom();
    add_sector_face(0);
    add_sector_face(kThetaCells);
    split_longest_edges(mesh_, facets,
                        [this](std::uint32_t a, std::uint32_t b) { return split_point(a, b); });
    return std::move(mesh_);
  }

 private:
  enum class Side { kCavity, kBack, kFlat };
  /// Where a vertex lies on the curved side it belongs to.
  struct Place {
    Side side = Side::kFlat;
    CavityPoint cavity;
    Polar back;
  };

  /// Line j is one of all lines, row m one of the coarse ones: only those go on behind the cavity, k > 0.
  int last_j() const { return static_cast<int>(lines_.size()) - 1; }
  int last_m() const { return static_cast<int>(coarse_.size()) - 1; }
  std::uint32_t& front(int i, int j) { return front_[i * lines_.size() + j]; }
  std::uint32_t& behind(int i, int m, int k) { return behind_[(i * coarse_.size() + m) * (kLayers + 1) + k]; }
  std::uint32_t back(int i, int m) { return behind(i, m, kLayers); }
  double height(std::uint32_t vertex) const { return places_[vertex].cavity.height; }
  bool same_height(std::uint32_t a, std::uint32_t b) const {
    return std::abs(height(a) - height(b)) < kSameHeight;
  }

  void add_nodes() {
    for (int j = 0; j <= last_j(); ++j)
      if (lines_[j].coarse) coarse_.push_back(j);
    front_.resize((kThetaCells + 1) * lines_.size());
    behind_.resize((kThetaCells + 1) * coarse_.size() * (kLayers + 1));
    for (int i = 0; i <= kThetaCells; ++i) {
      for (int j = 0; j <= last_j(); ++j) {
        const double phi = lines_[j].phi, cells = tread_.line_at(i, phi);
        const CavityPoint at{Tread::theta_of(cells, phi), phi, tread_.height_at(cells, phi)};
        front(i, j) = add(to_polar(at), {Side::kCavity, at, {}});
      }
      const bool on_sector_face = i == 0 || i == kThetaCells;
      for (int m = 0; m <= last_m(); ++m) add_nodes_behind(i, m, on_sector_face || m == 0 || m == last_m());
    }
  }

  void add_nodes_behind(int i, int m, bool on_rim) {
    const CavityPoint cavity = places_[front(i, coarse_[m])].cavity;
    const Polar foot = skirt(cavity.theta, cavity.phi);
    const Polar end{(static_cast<double>(i) / kThetaCells - 0.5) * 2.0 * kTheta, kBackRadius,
                    kSectionRadius * std::sin(kPhi * kDegree) * (2.0 * m / last_m() - 1.0)};
    behind(i, m, 0) = front(i, coarse_[m]);
    if (on_rim)
      for (int k = 1; k < kLayers; ++k)
        behind(i, m, k) = add(between(foot, end, (k - 1.0) / (kLayers - 1.0)), {});
    behind(i, m, kLayers) = add(end, {Side::kBack, {}, end});
  }

  std::uint32_t add(Polar at, const Place& place) {
    places_.push_back(place);
    return add_vertex(mesh_, to_part(at));
  }

  void add_cavity_and_back() {
    for (int i = 0; i < kThetaCells; ++i) {
      for (int j = 0; j < last_j(); ++j)
        add_cavity_cell({front(i, j), front(i + 1, j), front(i + 1, j + 1), front(i, j + 1)});
      for (int m = 0; m < last_m(); ++m)
        add_quad(mesh_, back(i, m), back(i, m + 1), back(i + 1, m + 1), back(i + 1, m));
    }
  }

  void add_top_and_bottom() {
    const int top = last_m();
    for (int i = 0; i < kThetaCells; ++i) {
      for (int k = 0; k < kLayers; ++k) {
        add_quad(mesh_, behind(i, 0, k), behind(i, 0, k + 1), behind(i + 1, 0, k + 1), behind(i + 1, 0, k));
        add_quad(mesh_, behind(i, top, k), behind(i + 1, top, k), behind(i + 1, top, k + 1),
                 behind(i, top, k + 1));
      }
    }
  }

  void add_sector_face(int i) {
    for (int m = 0; m < last_m(); ++m) {
      Chain edge{front(i, coarse_[m])};
      for (int j = coarse_[m]; j < coarse_[m + 1]; ++j) {
        const Chain cut = rungs(front(i, j), front(i, j + 1));
        edge.insert(edge.end(), cut.begin() + 1, cut.end());
      }
      add_profile_cell(edge, behind(i, m, 1), behind(i, m + 1, 1), i == 0);
      for (int k = 1; k < kLayers; ++k) {
        const std::uint32_t a = behind(i, m, k), b = behind(i, m + 1, k);
        const std::uint32_t c = behind(i, m + 1, k + 1), d = behind(i, m, k + 1);
        if (i == 0)
          add_quad(mesh_, a, b, c, d);
        else
          add_quad(mesh_, a, d, c, b);
      }
    }
  }

  /// The sector face between the cavity's edge and the skirt: a fan from behind the higher end of a wall.
  void add_profile_cell(const Chain& edge, std::uint32_t behind_first, std::uint32_t behind_last,
                        bool first) {
    const bool up = height(edge.back()) > height(edge.front());
    const std::uint32_t apex = up ? behind_last : behind_first;
    const auto add_facet = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      mesh_.facets.push_back(first ? std::array{a, b, c} : std::array{a, c, b});
    };
    for (std::size_t rung = 0; rung + 1 < edge.size(); ++rung) add_facet(apex, edge[rung], edge[rung + 1]);
    add_facet(behind_last, behind_first, up ? edge.front() : edge.back());
  }

  /// Corners counter-clockwise seen from the circle. Walls are cut into rows, corners into ladders.
  void add_cavity_cell(std::array<std::uint32_t, 4> q) {
    for (int turn = 0; turn < 4; ++turn, std::rotate(q.begin(), q.begin() + 1, q.end())) {
      if (same_height(q[0], q[1]) && same_height(q[2], q[3]))
        return add_rows(rungs(q[0], q[3]), rungs(q[1], q[2]));
      if (same_height(q[1], q[2]) && same_height(q[2], q[3])) {
        add_rows(rungs(q[0], q[2]), rungs(q[0], q[1]));
        return add_rows(rungs(q[0], q[3]), rungs(q[0], q[2]));
      }
    }
    assert(false && "the tread's grid lines miss a wall");
  }

  /// Between two chains of equal length, `right` to the right of `left`; they may start at the same vertex.
  void add_rows(const Chain& left, const Chain& right) {
    for (std::size_t rung = 0; rung + 1 < left.size(); ++rung) {
      if (left[rung] == right[rung])
        mesh_.facets.push_back({left[rung], right[rung + 1], left[rung + 1]});
      else
        add_quad(mesh_, left[rung], right[rung], right[rung + 1], left[rung + 1]);
    }
  }

  /// The edge from a to b of the cavity, with the vertices that cut it where it climbs a wall.
  Chain rungs(std::uint32_t a, std::uint32_t b) {
    if (same_height(a, b)) return {a, b};
    const std::uint32_t low = std::min(a, b), high = std::max(a, b);
    const auto [entry, is_new] = rungs_.try_emplace({low, high});
    Chain& chain = entry->second;
    if (is_new) {
      const CavityPoint from = places_[low].cavity, to = places_[high].cavity;
      const int count =
          static_cast<int>(std::ceil((std::abs(to.height - from.height) - kSameHeight) / kWallStep));
      chain.push_back(low);
      for (int rung = 1; rung < count; ++rung) {
        const CavityPoint at = between(from, to, static_cast<double>(rung) / count);
        chain.push_back(add(to_polar(at), {Side::kCavity, at, {}}));
      }
      chain.push_back(high);
    }
    return a < b ? chain : Chain(chain.rbegin(), chain.rend());
  }

  Vec3 split_point(std::uint32_t a, std::uint32_t b) {
    const Place p = places_[a], q = places_[b];
    Place middle;
    Vec3 at = straight_midpoint(mesh_, a, b);
    if (p.side == q.side && p.side == Side::kCavity) {
      middle = {Side::kCavity, between(p.cavity, q.cavity, 0.5), {}};
      at = to_part(to_polar(middle.cavity));
    } else if (p.side == q.side && p.side == Side::kBack) {
      middle = {Side::kBack, {}, between(p.back, q.back, 0.5)};
      at = to_part(middle.back);
    }
    places_.push_back(middle);
    return at;
  }

  const Tread tread_{};
  const std::vector<Tread::PhiLine> lines_ = Tread::phi_lines();
  std::vector<int> coarse_;  ///< indices into lines_
  FacetMesh mesh_;
  std::vector<Place> places_;  ///< of each vertex
  std::vector<std::uint32_t> front_, behind_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Chain> rungs_;
};

}  // namespace

Triangles tyre_segment(std::size_t facets) { return to_triangles(Tyre().build(facets)); }

}  // namespace tiltfeed::sim
