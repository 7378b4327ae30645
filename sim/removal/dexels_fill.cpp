#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "sim/removal/dexel_units.h"
#include "sim/removal/dexels.h"

namespace tiltfeed::sim {
namespace {

/// Twice the signed area of a, b and the place (u, v), the same number whichever of the two comes first.
struct Edge {
  double au, av, bu, bv;
  bool swapped;
  Edge(double u0, double v0, double u1, double v1) {
    swapped = u0 > u1 || (u0 == u1 && v0 > v1);
    au = swapped ? u1 : u0, av = swapped ? v1 : v0, bu = swapped ? u0 : u1, bv = swapped ? v0 : v1;
  }
  double area(double u, double v) const { return (bu - au) * (v - av) - (bv - av) * (u - au); }
  /// Every place is on exactly one side, and two facets that share the edge agree on which.
  bool left(double u, double v) const { return (area(u, v) >= 0.0) != swapped; }
};

std::pair<Vec3, Vec3> bounds(Vec3 a, Vec3 b, Vec3 c) {
  return {{std::min({a.x, b.x, c.x}), std::min({a.y, b.y, c.y}), std::min({a.z, b.z, c.z})},
          {std::max({a.x, b.x, c.x}), std::max({a.y, b.y, c.y}), std::max({a.z, b.z, c.z})}};
}

}  // namespace

Prism prism(const std::array<Point<Part>, 3>& p, double height) {
  Prism body;
  const Vec3 n = normalized(cross(p[1] - p[0], p[2] - p[0]));
  body.low = {kInfinity, kInfinity, kInfinity}, body.high = -body.low;
  for (int k = 0; k < 3; ++k) {
    const Vec3 from = from_origin(p[k]), out = cross(p[(k + 1) % 3] - p[k], n);
    body.normals[k] = out, body.offsets[k] = dot(out, from);
    for (const Vec3 corner : {from, from + n * height}) {
      body.low = {std::min(body.low.x, corner.x), std::min(body.low.y, corner.y),
                  std::min(body.low.z, corner.z)};
      body.high = {std::max(body.high.x, corner.x), std::max(body.high.y, corner.y),
                   std::max(body.high.z, corner.z)};
    }
  }
  body.normals[3] = -n, body.offsets[3] = -dot(n, from_origin(p[0]));
  body.normals[4] = n, body.offsets[4] = dot(n, from_origin(p[0])) + height;
  return body;
}

std::pair<int, int> Dexels::stripes_at(Vec3 low, Vec3 high) const {
  const Range r = range(low, high);
  if (r.u0 > r.u1 || r.v0 > r.v1) return {0, 0};
  int first = r.v0 / kTile * kStripes / rows_;
  while (stripes_[first].last <= r.v0) ++first;
  int last = first;
  while (stripes_[last].last <= r.v1) ++last;
  return {first, last + 1};
}

std::vector<std::vector<std::uint32_t>> Dexels::by_stripe(const pathgen::Mesh& mesh, double margin) const {
  return by_stripe(mesh.facets.size(), [&](std::uint32_t facet) {
    const auto& [a, b, c] = mesh.facets[facet];
    const Vec3 grow{margin, margin, margin};
    const auto [low, high] =
        bounds(from_origin(mesh.vertices[a]), from_origin(mesh.vertices[b]), from_origin(mesh.vertices[c]));
    return std::pair{low - grow, high + grow};
  });
}

/// Calls visit(line, piece) for the pieces of lines inside the shell, in order.
template <class Visit>
void Dexels::insides(int stripe, const pathgen::Mesh& shell, const std::vector<std::uint32_t>& facets,
                     const Visit& visit) const {
  struct Crossing {
    double at;
    std::uint32_t line;
    int turn;  // 1: into the material
  };
  const Stripe& s = stripes_[stripe];
  std::vector<Crossing> found;
  for (const std::uint32_t f : facets) {
    const auto& facet = shell.facets[f];
    const std::array p{from_origin(shell.vertices[facet[0]]), from_origin(shell.vertices[facet[1]]),
                       from_origin(shell.vertices[facet[2]])};
    const auto [low, high] = bounds(p[0], p[1], p[2]);
    const Range r = range(low, high, s);
    if (r.u0 > r.u1 || r.v0 > r.v1) continue;
    const auto cu = [&](int k) { return component(p[k], axis_u_); };
    const auto cv = [&](int k) { return component(p[k], axis_v_); };
    const Edge ab(cu(0), cv(0), cu(1), cv(1)), bc(cu(1), cv(1), cu(2), cv(2)), ca(cu(2), cv(2), cu(0), cv(0));
    const Vec3 n = cross(p[1] - p[0], p[2] - p[0]);
    const double n_axis = component(n, axis_);
    if (n_axis == 0.0) continue;
    for (int v = r.v0; v <= r.v1; ++v) {
      for (int u = r.u0; u <= r.u1; ++u) {
        const double pu = low_u_ + (u + 0.5) * cell_, pv = low_v_ + (v + 0.5) * cell_;
        const bool side = ab.left(pu, pv);
        if (bc.left(pu, pv) != side || ca.left(pu, pv) != side) continue;
        const double at =
            component(p[0], axis_) -
            ((pu - cu(0)) * component(n, axis_u_) + (pv - cv(0)) * component(n, axis_v_)) / n_axis;
        found.push_back({at, static_cast<std::uint32_t>((v - s.first) * lines_u_ + u), side ? -1 : 1});
      }
    }
  }
  // By line; a line's begin moves on to its end while they are put there.
  std::vector<std::uint32_t> end(s.nodes.size() + 1, 0);
  for (const Crossing& c : found) ++end[c.line + 1];
  for (std::size_t line = 0; line + 1 < end.size(); ++line) end[line + 1] += end[line];
  std::vector<Crossing> crossings(found.size());
  for (const Crossing& c : found) crossings[end[c.line]++] = c;
  std::uint32_t begin = 0;
  for (std::uint32_t line = 0; line + 1 < end.size(); begin = end[line++]) {
    const std::span<Crossing> of(crossings.data() + begin, crossings.data() + end[line]);
    std::sort(of.begin(), of.end(), [](const Crossing& a, const Crossing& b) {
      return a.at != b.at ? a.at < b.at : a.turn > b.turn;
    });
    int depth = 0;
    double from = 0.0;
    for (const Crossing& c : of) {
      if (depth == 0 && c.turn > 0) from = c.at;
      if (depth == 1 && c.turn < 0) visit(line, Piece{to_units(from), to_units(c.at)});
      depth += c.turn;
    }
  }
}

void Dexels::fill(int stripe, const pathgen::Mesh& shell, const std::vector<std::uint32_t>& facets) {
  insides(stripe, shell, facets,
          [&](std::uint32_t line, Piece piece) { add(stripes_[stripe], line, piece); });
}

void Dexels::fill(int stripe, const SweptBody& body) {
  Stripe& s = stripes_[stripe];
  const Range r = range(body.low, body.high, s);
  if (r.u0 > r.u1 || r.v0 > r.v1) return;
  const double low = component(body.low, axis_), high = component(body.high, axis_);
  std::array<double, 3> d{};
  d[axis_] = 1.0;
  std::optional<LineCutter> cutter;
  for (int v = r.v0; v <= r.v1; ++v) {
    for (int u = r.u0; u <= r.u1; ++u) {
      const auto line = static_cast<std::uint32_t>((v - s.first) * lines_u_ + u);
      const Piece first = s.nodes[line].piece;
      if (first.low * kUnit <= low && first.high * kUnit >= high) continue;
      if (!cutter) cutter.emplace(body, Vec3{d[0], d[1], d[2]});
      if (const auto inside = (*cutter)(origin(u, v), low, high))
        add(s, line, {to_units(inside->enter), to_units(inside->leave)});
    }
  }
}

void Dexels::fill(int stripe, const pathgen::Box& box) {
  Stripe& s = stripes_[stripe];
  const Range r = range(from_origin(box.min), from_origin(box.max), s);
  for (int v = r.v0; v <= r.v1; ++v)
    for (int u = r.u0; u <= r.u1; ++u)
      add(s, static_cast<std::uint32_t>((v - s.first) * lines_u_ + u),
          {to_units(component(box.min, axis_)), to_units(component(box.max, axis_))});
}

Dexels::Lack Dexels::missing(int stripe, const pathgen::Mesh& shell, const std::vector<std::uint32_t>& facets,
                             double slack) const {
  Lack most;
  insides(stripe, shell, facets, [&](std::uint32_t line, Piece wanted) {
    // What no piece of material covers, from below upwards.
    std::int32_t from = wanted.low;
    const auto lack = [&](std::int32_t to) {
      const double gap = (static_cast<double>(to) - from) * kUnit;
      if (gap <= std::max(slack, most.length)) return;
      const int at = static_cast<int>(line);
      const Point<Part> foot = origin(at % lines_u_, at / lines_u_ + stripes_[stripe].first);
      std::array<double, 3> p{foot.x, foot.y, foot.z};
      p[axis_] = 0.5 * kUnit * (static_cast<double>(from) + to);
      most = {gap, {p[0], p[1], p[2]}};
    };
    for (std::uint32_t at = line; at != kNone; at = node(stripe, at).next) {
      const Piece piece = node(stripe, at).piece;
      if (piece.low >= piece.high || piece.high <= from) continue;
      if (piece.low >= wanted.high) break;
      if (piece.low > from) lack(piece.low);
      from = std::max(from, piece.high);
    }
    if (from < wanted.high) lack(wanted.high);
  });
  return most;
}

void Dexels::fill(int stripe, const Prism& prism) {
  Stripe& s = stripes_[stripe];
  const Range r = range(prism.low, prism.high, s);
  for (int v = r.v0; v <= r.v1; ++v) {
    for (int u = r.u0; u <= r.u1; ++u) {
      double enter = component(prism.low, axis_), leave = component(prism.high, axis_);
      const Vec3 foot = from_origin(origin(u, v));
      for (std::size_t i = 0; i < prism.normals.size() && enter < leave; ++i) {
        const double slope = component(prism.normals[i], axis_),
                     left = prism.offsets[i] - dot(prism.normals[i], foot);
        if (slope > 0.0)
          leave = std::min(leave, left / slope);
        else if (slope < 0.0)
          enter = std::max(enter, left / slope);
        else if (left < 0.0)
          leave = -kInfinity;
      }
      if (enter < leave)
        add(s, static_cast<std::uint32_t>((v - s.first) * lines_u_ + u), {to_units(enter), to_units(leave)});
    }
  }
}

}  // namespace tiltfeed::sim
