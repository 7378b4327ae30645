#pragma once
// Material as pieces of parallel lines (dexels): one bundle of lines along x, y or z, `cell` apart. Ends are
// whole multiples of kUnit, so sums are exact and nothing depends on the order of threads.

#include <cstdint>
#include <utility>
#include <vector>

#include "pathgen/mesh/mesh.h"
#include "sim/removal/dexel_units.h"
#include "sim/removal/swept_body.h"

namespace tiltfeed::sim {

class Sheet;

/// A piece of a line, in units from the coordinate zero: material from low to high.
struct Piece {
  std::int32_t low = 0, high = 0;
};

/// A convex body bounded by planes: normals[i].x <= offsets[i].
struct Prism {
  std::array<Vec3, 5> normals;
  std::array<double, 5> offsets;
  Vec3 low, high;  ///< bounds
};
/// The triangle pushed along its normal by `height`.
Prism prism(const std::array<Point<Part>, 3>& triangle, double height);

/// Material that was on a line through `origin` and is taken away, mm along the line.
struct Removed {
  Point<Part> origin;
  double low = 0.0, high = 0.0;
};

/// What one body did to the lines of one stripe.
struct Cut {
  std::int64_t removed = 0;  ///< length, units
  double deepest = 0.0;      ///< most that the middle of a removed piece lay inside the body, mm
  Point<Part> place;         ///< there
};

class Dexels {
 public:
  static constexpr double kUnit = kDexelUnit;  ///< mm
  static constexpr int kStripes = 16;          ///< whose lines can be worked at the same time
  static constexpr std::size_t kBytesPerLine = 14;

  /// Empty lines along `axis` (0 x, 1 y, 2 z) through the middles of cells that fill the box.
  Dexels(int axis, const pathgen::Box& box, double cell);
  /// How many lines such a bundle has.
  static std::uint64_t line_count(int axis, const pathgen::Box& box, double cell);

  int axis() const { return axis_; }
  /// Sets the lines of a stripe to the inside of closed oriented shells, of which only `facets` may be over
  /// or under them. Requires: outward normals.
  void fill(int stripe, const pathgen::Mesh& shell, const std::vector<std::uint32_t>& facets);
  void fill(int stripe, const SweptBody& body);  ///< adds a convex body
  void fill(int stripe, const pathgen::Box& box);
  void fill(int stripe, const Prism& prism);
  /// By stripe, in order: the numbers of those of `count` things that could meet its lines; box(i): the
  /// bounds of one, low and high.
  template <class BoxOf>
  std::vector<std::vector<std::uint32_t>> by_stripe(std::size_t count, const BoxOf& box) const;
  /// The same of facets and all within `margin` of them.
  std::vector<std::vector<std::uint32_t>> by_stripe(const pathgen::Mesh& mesh, double margin) const;
  /// What is not the part's: `shell`'s lines inside it that have no material, if longer than `slack` mm; the
  /// middle of the longest.
  struct Lack {
    double length = 0.0;
    Point<Part> place;
  };
  Lack missing(int stripe, const pathgen::Mesh& shell, const std::vector<std::uint32_t>& facets,
               double slack) const;

  /// The stripes in which a body can meet material that is there now, [first, second). May be asked while
  /// other threads cut.
  std::pair<int, int> stripes(const SweptBody& body) const;
  /// Takes the body away. `measure`: also find `deepest`. `gone`: what is taken away is put behind it.
  Cut cut(int stripe, const SweptBody& body, bool measure, std::vector<Removed>* gone = nullptr);
  /// Takes note of how far up and down material reaches; call after filling, before cutting.
  void settle(int stripe);

  std::int64_t length(int stripe) const;  ///< of all material, units
  double volume() const;                  ///< mm^3
  std::size_t bytes() const;
  /// Calls visit(origin, low, high) for each piece of material, low and high in mm along the line.
  template <class Visit>
  void each(int stripe, const Visit& visit) const {
    each_line(stripe, [&](std::uint32_t line, int u, int v) {
      for (std::uint32_t at = line; at != kNone; at = node(stripe, at).next)
        if (node(stripe, at).piece.low < node(stripe, at).piece.high)
          visit(origin(u, v), node(stripe, at).piece.low * kUnit, node(stripe, at).piece.high * kUnit);
    });
  }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFF;
  static constexpr int kTile = 8;  ///< lines on a side of what is left out together
  struct Node {
    Piece piece;
    std::uint32_t next = kNone;
  };
  struct Stripe {
    int first = 0, last = 0;  ///< rows
    std::vector<Node> nodes;  ///< the first of each line, then further pieces
    std::uint32_t spare = kNone;
    std::vector<Piece> tiles;         ///< bounds of the material
    std::vector<std::uint8_t> stale;  ///< cuts since the bounds were made
  };
  struct Range {
    int u0, u1, v0, v1;  ///< inclusive
  };

  const Node& node(int stripe, std::uint32_t at) const { return stripes_[stripe].nodes[at]; }
  template <class Visit>
  void each_line(int stripe, const Visit& visit) const {
    const Stripe& s = stripes_[stripe];
    for (int v = s.first; v < s.last; ++v)
      for (int u = 0; u < lines_u_; ++u)
        visit(static_cast<std::uint32_t>((v - s.first) * lines_u_ + u), u, v);
  }
  Point<Part> origin(int u, int v) const;
  /// The lines in a box, of the rows of a stripe, or of all.
  Range range(Vec3 low, Vec3 high, const Stripe& s) const { return range(low, high, s.first, s.last); }
  Range range(Vec3 low, Vec3 high) const { return range(low, high, 0, lines_v_); }
  Range range(Vec3 low, Vec3 high, int first_row, int end_row) const;
  bool meets_tile(const Range& range, int tile_v, const Stripe& stripe, Piece along) const;
  double lowest(const SweptBody& body, const Sheet& shadow, int tile_u, int tile_v) const;
  /// Without what it has along the lines.
  template <class Vector>
  Vector across(Vector v) const {
    (axis_ == 0 ? v.x : axis_ == 1 ? v.y : v.z) = 0.0;
    return v;
  }
  void add(Stripe& stripe, std::uint32_t line, Piece piece);
  std::int64_t remove(Stripe& stripe, std::uint32_t line, Piece piece, Piece& longest,
                      const Point<Part>& origin, std::vector<Removed>* gone);
  void bound_tile(Stripe& stripe, int tile_u, int tile_v) const;
  /// The stripes whose lines could meet what is in a box, [first, second).
  std::pair<int, int> stripes_at(Vec3 low, Vec3 high) const;
  template <class Visit>
  void insides(int stripe, const pathgen::Mesh& shell, const std::vector<std::uint32_t>& facets,
               const Visit& visit) const;

  int axis_, axis_u_, axis_v_;
  double cell_, per_mm_, low_u_, low_v_;
  int lines_u_, lines_v_, tiles_u_, rows_;
  std::vector<Stripe> stripes_;
};

template <class BoxOf>
std::vector<std::vector<std::uint32_t>> Dexels::by_stripe(std::size_t count, const BoxOf& box) const {
  std::vector<std::vector<std::uint32_t>> numbers(kStripes);
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto& [low, high] = box(i);
    const auto [first, end] = stripes_at(low, high);
    for (int stripe = first; stripe < end; ++stripe) numbers[stripe].push_back(i);
  }
  return numbers;
}

}  // namespace tiltfeed::sim
