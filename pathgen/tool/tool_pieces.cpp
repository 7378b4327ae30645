#include "pathgen/tool/tool_pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tiltfeed::pathgen {

namespace {

/// Radii that differ by less, mm, do so by rounding.
constexpr double kSameRadius = 1e-9;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// (T1) The cutting part, its reference at the centre of its rounded edge, grown by the stock left.
ToolPiece cutting_part(const PlanOptions& o) {
  const Cutter& cutter = o.cutter;
  ToolPiece piece;
  piece.corner = cutter.nose_radius() + o.allowance;
  piece.flat = cutter.radius() - cutter.nose_radius() + o.radial_stock;
  piece.outer = piece.flat + piece.corner;
  piece.above_reference = -o.axial_stock;
  piece.length = cutter.cutting_end() - cutter.nose_radius() + o.axial_stock;
  if (cutter.type == CutterType::kTaperBall) {
    piece.taper_sin = std::sin(cutter.taper.radians()), piece.taper_cos = std::cos(cutter.taper.radians());
    piece.outer = cutter.cutting_top_radius() + o.radial_stock + o.allowance;
  }
  return piece;
}

/// (T2) A step of shank or holder between two heights over the tip: a disc, and a cone where it widens.
ToolPiece step(ToolPart part, double from, double to, double lower, double upper, double grown,
               const PlanOptions& o) {
  ToolPiece piece;
  piece.part = part;
  piece.flat = lower + grown + o.radial_stock;
  piece.outer = piece.flat;
  if (upper > lower) {
    const double slant = std::hypot(upper - lower, to - from);
    piece.taper_sin = (upper - lower) / slant, piece.taper_cos = (to - from) / slant;
    piece.outer = upper + grown + o.radial_stock;
  }
  piece.above_reference = from - grown - o.axial_stock - reference_height(o.cutter);
  piece.length = to - from + grown + o.axial_stock;
  return piece;
}

/// How wide the piece is at this height over the CL reference, with all that is straight above it, mm; below
/// its lower end: less than nothing.
double radius_at(const ToolPiece& piece, double height) {
  const double h = height - piece.above_reference;
  if (h < -piece.corner) return -kInfinity;
  const double cone_from = -piece.corner * piece.taper_sin;
  if (h <= cone_from || !piece.has_cone())
    return std::min(piece.outer, piece.flat + std::sqrt(piece.corner * piece.corner -
                                                        std::min(h, 0.0) * std::min(h, 0.0)));
  return std::min(piece.outer, piece.flat + piece.corner * piece.taper_cos +
                                   (h - cone_from) * piece.taper_sin / piece.taper_cos);
}

/// Where its outline bends, over the CL reference, mm.
std::vector<double> bends(const ToolPiece& piece) {
  std::vector<double> at{piece.above_reference};
  if (piece.has_cone()) at.push_back(piece.above_reference + piece.cone_height(piece.outer));
  return at;
}

/// Both outlines are straight between their bends, but for a rounding of `below`, which bulges.
bool covers(const ToolPiece& below, const ToolPiece& piece) {
  std::vector<double> heights = bends(piece);
  for (const double h : bends(below)) heights.push_back(std::max(h, piece.above_reference));
  return std::all_of(heights.begin(), heights.end(),
                     [&](double h) { return radius_at(piece, h) <= radius_at(below, h) + kSameRadius; });
}

}  // namespace

double distance_to_piece(const ToolPiece& piece, double d, double h) {
  if (piece.has_cone()) {
    const double on_cone = (d - piece.flat) * piece.taper_cos - h * piece.taper_sin - piece.corner;
    const bool beside = (d - piece.flat) * piece.taper_sin + h * piece.taper_cos > 0.0;
    if (beside) return std::max(on_cone, d - piece.outer);
  } else if (h >= 0.0) {
    return d - piece.outer;
  }
  const double beyond = std::max(d - piece.flat, 0.0);
  return std::sqrt(beyond * beyond + h * h) - piece.corner;
}

std::vector<ToolPiece> all_pieces(const PlanOptions& options) {
  const Cutter& cutter = options.cutter;
  std::vector<ToolPiece> pieces{cutting_part(options)};
  if (cutter.cutting_end() < cutter.shank_length)
    pieces.push_back(step(ToolPart::kShank, cutter.cutting_end(), cutter.shank_length, cutter.shank_radius(),
                          cutter.shank_radius(), options.allowance + options.shank.clearance, options));
  double height = cutter.shank_length;
  for (const HolderStep& s : cutter.holder) {
    pieces.push_back(step(ToolPart::kHolder, height, height + s.length, s.lower_diameter / 2.0,
                          s.upper_diameter / 2.0, options.allowance + options.holder.clearance, options));
    height += s.length;
  }
  return pieces;
}

std::vector<bool> in_shadow(const PlanOptions& options) {
  // The stock that is to stay grows all of them alike.
  PlanOptions bare = options;
  bare.allowance = bare.radial_stock = bare.axial_stock = 0.0;
  const std::vector<ToolPiece> pieces = all_pieces(bare);
  std::vector<bool> hidden;
  for (auto piece = pieces.begin(); piece != pieces.end(); ++piece)
    hidden.push_back(
        std::any_of(pieces.begin(), piece, [&](const ToolPiece& below) { return covers(below, *piece); }));
  return hidden;
}

std::vector<ToolPiece> tool_pieces(const PlanOptions& options) {
  const std::vector<ToolPiece> all = all_pieces(options);
  const std::vector<bool> hidden = in_shadow(options);
  std::vector<ToolPiece> pieces;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (!hidden[i]) pieces.push_back(all[i]);
  return pieces;
}

double left_at_taper_edge(const PlanOptions& options) {
  if (options.cutter.type != CutterType::kTaperBall) return 0.0;
  return options.allowance * (1.0 / std::cos(options.cutter.taper.radians() / 2.0) - 1.0);
}

PlanOptions as_of_fixtures(PlanOptions options) {
  const FixtureRoom& room = options.fixture_room;
  options.allowance = room.cutter, options.radial_stock = 0.0, options.axial_stock = 0.0;
  options.shank = {room.shank - room.cutter, Reaction::kTrim};
  options.holder = {room.holder - room.cutter, Reaction::kTrim};
  options.fixtures = nullptr;
  return options;
}

std::vector<ToolPiece> fixture_pieces(const PlanOptions& options) {
  if (!options.fixtures) return {};
  std::vector<ToolPiece> pieces = with_lower_discs(tool_pieces(as_of_fixtures(options)));
  for (ToolPiece& piece : pieces) piece.at_fixtures = true;
  return pieces;
}

PlanOptions without_leaning_parts(PlanOptions options) {
  if (options.shank.reaction == Reaction::kTilt) {
    options.cutter.shank_diameter = 0.0, options.shank = {};
    options.fixture_room.shank = options.fixture_room.cutter;
  }
  if (options.holder.reaction == Reaction::kTilt) options.cutter.holder.clear(), options.holder = {};
  options.lean = {};
  return options;
}

std::vector<ToolPiece> with_lower_discs(const std::vector<ToolPiece>& pieces) {
  std::vector<ToolPiece> all;
  for (const ToolPiece& piece : pieces) {
    const bool sharp = std::none_of(all.begin(), all.end(), [&](const ToolPiece& below) {
      return piece.flat <= radius_at(below, piece.above_reference);
    });
    if (piece.corner == 0.0 && piece.has_cone() && sharp) {
      ToolPiece disc = piece;
      disc.outer = disc.flat, disc.taper_sin = 0.0, disc.taper_cos = 1.0;
      all.push_back(disc);
    }
    all.push_back(piece);
  }
  return all;
}

}  // namespace tiltfeed::pathgen
