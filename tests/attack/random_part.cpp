#include "tests/attack/random_part.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>

#include "sim/parts/parts.h"

namespace tiltfeed::attack {
using namespace pathgen;
namespace {

/// Larger parts are cut down to a piece more often: reading and judging them costs more than the attack.
constexpr std::size_t kManyFacets = 10'000, kTooManyFacets = 60'000, kPieceFacets = 4'000;

using Corners = std::array<Point<Part>, 3>;

struct Bounds {
  Point<Part> low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  void add(Point<Part> p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
};
Bounds bounds_of(const Soup& soup) {
  Bounds b;
  for (const Corners& f : soup)
    for (const Point<Part>& p : f) b.add(p);
  return b;
}

void quad(Soup& s, Point<Part> a, Point<Part> b, Point<Part> c, Point<Part> d) {
  s.push_back({a, b, c});
  s.push_back({a, c, d});
}

/// Columns of random heights on a grid: walls along z and sharp corners. Closed.
Soup terrace(Dice& dice) {
  const int n = 2 + static_cast<int>(dice.below(7));
  std::vector<double> height;
  for (int i = 0; i < n * n; ++i) height.push_back(dice.chance(0.3) ? 1.0 : dice.uniform(1.0, 5.0));
  const auto h = [&](int i, int j) { return i < 0 || j < 0 || i >= n || j >= n ? 0.0 : height[i * n + j]; };
  Soup s;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double x = i, y = j, z = h(i, j);
      quad(s, {x, y, z}, {x + 1, y, z}, {x + 1, y + 1, z}, {x, y + 1, z});
      quad(s, {x, y, 0}, {x, y + 1, 0}, {x + 1, y + 1, 0}, {x + 1, y, 0});
    }
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j < n; ++j) {
      const double x = i, y = j;
      const auto wall_x = [&](double low, double high) {
        quad(s, {x, y, low}, {x, y, high}, {x, y + 1, high}, {x, y + 1, low});
      };
      if (h(i - 1, j) > h(i, j)) {
        quad(s, {x, y, h(i, j)}, {x, y + 1, h(i, j)}, {x, y + 1, h(i - 1, j)}, {x, y, h(i - 1, j)});
      } else if (h(i, j) > h(i - 1, j)) {
        wall_x(h(i - 1, j), h(i, j));
      }
      if (h(j, i - 1) > h(j, i)) {
        quad(s, {y, x, h(j, i)}, {y, x, h(j, i - 1)}, {y + 1, x, h(j, i - 1)}, {y + 1, x, h(j, i)});
      } else if (h(j, i) > h(j, i - 1)) {
        quad(s, {y, x, h(j, i - 1)}, {y + 1, x, h(j, i - 1)}, {y + 1, x, h(j, i)}, {y, x, h(j, i)});
      }
    }
  return s;
}

/// A random outline turned about z, its corners sharp. Closed.
Soup turned(Dice& dice) {
  const int rings = 3 + static_cast<int>(dice.below(10)), segments = 5 + static_cast<int>(dice.below(60));
  std::vector<std::array<double, 2>> outline{{0.0, 0.0}};
  double z = 0.0;
  for (int i = 0; i < rings; ++i) {
    outline.push_back({dice.uniform(1.0, 6.0), z});
    if (i + 1 < rings && !dice.chance(0.2)) z += dice.uniform(0.05, 2.0);
  }
  outline.push_back({0.0, z + 1e-3});
  Soup s;
  const auto at = [&](std::size_t i, int k) {
    const double turn = 2.0 * kPi * (k % segments) / segments, r = outline[i][0];
    return Point<Part>{r * std::cos(turn), r * std::sin(turn), outline[i][1]};
  };
  for (std::size_t i = 0; i + 1 < outline.size(); ++i)
    for (int k = 0; k < segments; ++k) {
      const Point<Part> a = at(i, k), b = at(i, k + 1), c = at(i + 1, k + 1), d = at(i + 1, k);
      if (!(a == b)) s.push_back({a, b, c});
      if (!(c == d)) s.push_back({a, c, d});
    }
  return s;
}

/// Twisted, thin, higher than wide: something that a shank can lean against. Closed.
Soup blade(Dice& dice) {
  const int around = 8 + 2 * static_cast<int>(dice.below(12)), up = 3 + static_cast<int>(dice.below(20));
  const double thick = dice.uniform(0.02, 0.4), twist = dice.uniform(-2.0, 2.0),
               high = dice.uniform(2.0, 8.0), bow = dice.uniform(-1.0, 1.0);
  const auto at = [&](int i, int j) {
    const double a = 2.0 * kPi * (i % around) / around, f = static_cast<double>(j) / up;
    const double x = (1.0 - 0.4 * f) * std::cos(a), y = thick * (1.0 - 0.4 * f) * std::sin(a) + bow * f * f;
    return Point<Part>{x * std::cos(twist * f) - y * std::sin(twist * f),
                       x * std::sin(twist * f) + y * std::cos(twist * f), high * f};
  };
  Soup s;
  for (int j = 0; j < up; ++j)
    for (int i = 0; i < around; ++i) quad(s, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
  for (int i = 1; i + 1 < around; ++i) {
    s.push_back({at(0, 0), at(i + 1, 0), at(i, 0)});
    s.push_back({at(0, up), at(i, up), at(i + 1, up)});
  }
  return s;
}

Soup torus(Dice& dice) {
  const int around = 8 + static_cast<int>(dice.below(40)), across = 6 + static_cast<int>(dice.below(24));
  const double radius = dice.uniform(0.2, 0.9);
  const auto at = [&](int i, int j) {
    const double u = 2.0 * kPi * (i % around) / around, v = 2.0 * kPi * (j % across) / across;
    const double r = 1.0 + radius * std::cos(v);
    return Point<Part>{r * std::cos(u), r * std::sin(u), radius * std::sin(v)};
  };
  Soup s;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) quad(s, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
  return s;
}

Soup shape(Dice& dice, std::string& story) {
  switch (dice.below(4)) {
    case 0:
      return story = "terrace", terrace(dice);
    case 1:
      return story = "turned", turned(dice);
    case 2:
      return story = "blade", blade(dice);
    default:
      return story = "torus", torus(dice);
  }
}

/// The facets whose first corner is within a ball about a corner: an open piece.
Soup piece(const Soup& whole, std::size_t most, Dice& dice) {
  const Point<Part> at = whole[dice.below(whole.size())][0];
  std::vector<double> away;
  for (const Corners& f : whole) away.push_back(distance(f[0], at));
  std::vector<double> sorted = away;
  const std::size_t rank = std::min(most, whole.size()) - 1;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(rank), sorted.end());
  Soup kept;
  for (std::size_t i = 0; i < whole.size(); ++i)
    if (away[i] <= sorted[rank]) kept.push_back(whole[i]);
  return kept;
}

void holes(Soup& s, Dice& dice) {
  const std::size_t count = 1 + dice.below(6);
  for (std::size_t i = 0; i < count && s.size() > 8; ++i)
    s.erase(s.begin() + static_cast<std::ptrdiff_t>(dice.below(s.size())));
}
void flips(Soup& s, Dice& dice) {
  const double share = dice.spread(1e-3, 0.6);
  for (Corners& f : s)
    if (dice.chance(share)) std::swap(f[1], f[2]);
}
/// Corners of one place move together, or each facet's on its own: cracks.
void jitter(Soup& s, double size, bool together, Dice& dice) {
  std::map<std::array<double, 3>, Vec3> moves;
  for (Corners& f : s)
    for (Point<Part>& p : f) {
      const Vec3 own = dice.direction() * (size * dice.unit());
      p = p + (together ? moves.try_emplace({p.x, p.y, p.z}, own).first->second : own);
    }
}
void slivers(Soup& s, double size, Dice& dice) {
  const std::size_t count = 1 + dice.below(12);
  for (std::size_t i = 0; i < count; ++i) {
    Corners& f = s[dice.below(s.size())];
    const auto [a, b, c] = f;
    const Point<Part> m = lerp(a, b, dice.uniform(0.05, 0.95)) + dice.direction() * (size * dice.unit());
    f = {a, m, c};
    s.push_back({m, b, c});
    if (dice.chance(0.3)) s.push_back({a, b, m});
  }
}
void repeats(Soup& s, Dice& dice) {
  const std::size_t count = 1 + dice.below(8);
  for (std::size_t i = 0; i < count; ++i) {
    Corners f = s[dice.below(s.size())];
    if (dice.chance(0.5)) std::swap(f[1], f[2]);
    s.push_back(f);
  }
}
/// Another shape, or the part itself again, through the first.
void crossing(Soup& s, Dice& dice) {
  std::string name;
  const Bounds b = bounds_of(s);
  const double size = distance(b.low, b.high);
  Soup other = dice.chance(0.2) && s.size() < kManyFacets ? s : shape(dice, name);
  const Bounds o = bounds_of(other);
  const double scale = size * dice.uniform(0.1, 0.8) / distance(o.low, o.high);
  const Rotation turn = rotation_about(dice.direction(), dice.uniform(0.0, 2.0 * kPi));
  const Point<Part> to = s[dice.below(s.size())][0];
  for (Corners& f : other) {
    for (Point<Part>& p : f) p = to + turn * ((p - lerp(o.low, o.high, 0.5)) * scale);
    s.push_back(f);
  }
}

void damage(RandomPart& part, Dice& dice) {
  Soup& s = part.facets;
  const double fine = part.size * dice.spread(1e-7, 1e-2);
  if (dice.chance(0.15)) crossing(s, dice), part.story += ", crossing shell";
  if (dice.chance(0.15)) slivers(s, fine, dice), part.story += ", slivers";
  if (dice.chance(0.10)) repeats(s, dice), part.story += ", repeated facets";
  if (dice.chance(0.15)) holes(s, dice), part.story += ", holes";
  if (dice.chance(0.15)) flips(s, dice), part.story += ", flips";
  if (dice.chance(0.15)) jitter(s, fine, true, dice), part.story += ", noise";
  if (dice.chance(0.15)) jitter(s, fine, false, dice), part.story += ", cracks";
}

Soup source(Dice& dice, const std::vector<std::string>& models, std::string& story) {
  if (!models.empty() && dice.chance(0.6)) {
    const std::string& file = models[dice.below(models.size())];
    story = std::filesystem::path(file).stem().string();
    if (auto stl = read_stl(file, 1.0)) return std::move(stl->facets);
  }
  if (dice.chance(0.45)) {
    story = dice.one_of<const char*>({"sphere", "handle", "pin", "tyre"});
    return *sim::part_by_name(story);
  }
  return shape(dice, story);
}

float as_stored(double v) { return static_cast<float>(v); }

}  // namespace

RandomPart random_part(Dice& dice, const std::vector<std::string>& models) {
  RandomPart part;
  part.facets = source(dice, models, part.story);
  // Files that are refused have no facets.
  while (part.facets.empty()) part.facets = shape(dice, part.story);
  const double cut = part.facets.size() > kTooManyFacets ? 0.97
                     : part.facets.size() > kManyFacets  ? 0.75
                                                         : 0.1;
  if (dice.chance(cut)) {
    part.facets = piece(part.facets, 20 + dice.below(std::min(part.facets.size(), kPieceFacets)), dice);
    part.story += ", a piece";
  }
  const Bounds before = bounds_of(part.facets);
  const double scale = dice.spread(15.0, 150.0) / std::max(1e-9, distance(before.low, before.high));
  const Vec3 aside = dice.chance(0.2) ? dice.direction() * dice.uniform(0.0, 300.0) : Vec3{};
  for (Corners& f : part.facets)
    for (Point<Part>& p : f) p = Point<Part>{} + (p - lerp(before.low, before.high, 0.5)) * scale + aside;
  const Bounds clean = bounds_of(part.facets);
  part.size = distance(clean.low, clean.high);
  if (dice.chance(0.65)) damage(part, dice);
  for (Corners& f : part.facets)
    for (Point<Part>& p : f) p = {as_stored(p.x), as_stored(p.y), as_stored(p.z)};
  const Bounds b = bounds_of(part.facets);
  part.size = distance(b.low, b.high), part.centre = lerp(b.low, b.high, 0.5);
  return part;
}

}  // namespace tiltfeed::attack
