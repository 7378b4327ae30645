// ControlReader's arcs: G2 and G3 with I J K, C round CC. Each control's own rules of where the centre is.

#include <numbers>

#include "sim/control/control_reader.h"
#include "sim/gcode/arc_way.h"

namespace tiltfeed::sim {
namespace {

// No posted arc goes further round; the sum of two rounded angles.
constexpr double kHalfRound = std::numbers::pi + 1e-6;

}  // namespace

/// A Sinumerik's and a Heidenhain's turn the tool's length, too.
bool ControlReader::selects_plane(int tenths) const {
  if (tenths == 170) return true;
  return (tenths == 180 || tenths == 190) && !tnc() && dialect_ != config::Dialect::kSiemens;
}

/// I J K stand in arcs of their plane, or say a Heidenhain's pole.
ControlReader::Wrong ControlReader::centre_words(const ControlWords& words) const {
  const bool iso = dialect_ == config::Dialect::kHeidenhainIso;
  for (const char letter : {'I', 'J', 'K'}) {
    if (!words.has(letter)) continue;
    if (iso ? letter == 'K' : dialect_ == config::Dialect::kHeidenhain)
      return std::string(1, letter) + " is no word of this machine";
    if (iso) continue;
    if (arc_ == 0) return std::string(1, letter) + " belongs to no arc (G2, G3)";
    if (letter == arc_plane(arc_plane_).centre[2])
      return std::string(1, letter) + " is no word of an arc in G" + std::to_string(arc_plane_) +
             ": is its plane lost?";
  }
  return std::nullopt;
}

/// CC X Y, or I J: absolute. A line of it moves nothing; true: it was one.
bool ControlReader::take_pole(const ControlWords& words) {
  const bool dialogue = words.named("CC");
  if (!dialogue && dialect_ != config::Dialect::kHeidenhainIso) return false;
  for (std::size_t i = 0; i < pole_.size(); ++i) {
    const char letter = dialogue ? (i == 0 ? 'X' : 'Y') : (i == 0 ? 'I' : 'J');
    if (words.has(letter)) pole_[i] = words[letter] * unit_;
  }
  return dialogue;
}

/// Where the axes stand, in the words of arcs.
Joints ControlReader::arc_words() const {
  if (!plane_) return at_;
  if (plane_->at) return {plane_->at->x, plane_->at->y, plane_->at->z, at_.a, at_.c};
  const Joints tip = frames_.tip_words(at_);
  const Vec3 place = transposed(plane_->told.frame) * (Vec3{tip.x, tip.y, tip.z} - plane_->told.origin);
  return {place.x, place.y, place.z, at_.a, at_.c};
}

ControlReader::Wrong ControlReader::put_arc(const ControlWords& words, const Joints& start,
                                            std::vector<ControlBlock>& blocks) {
  if (tcp_) return "an arc under TCP is not understood";
  if (words.has('R')) return "an arc by its radius is not understood; post with I J K";
  const bool dialogue = dialect_ == config::Dialect::kHeidenhain;
  if (dialogue && words.named("DR+") == words.named("DR-"))
    return "an arc without DR+ or DR-: which way round?";
  const ArcPlane& plane = arc_plane(arc_plane_);
  ArcWords arc{arc_plane_, dialogue ? words.named("DR-") : arc_ == 2, 0.0, 0.0};
  if (tnc()) {
    if (!pole_[0] || !pole_[1])
      return std::string("an arc before ") + (dialogue ? "CC" : "I and J") + " says its centre";
    arc.first = *pole_[0], arc.second = *pole_[1];
  } else {
    if (!words.has(plane.centre[0]) && !words.has(plane.centre[1]))
      return std::string("an arc without ") + plane.centre[0] + " and " + plane.centre[1];
    const auto offset = [&](char letter) {
      if (!words.has(letter)) return 0.0;
      return words[letter] * unit_ * (counts_points_ && !words.has_point(letter) ? 1e-3 : 1.0);
    };
    arc.first = start.*plane.first + offset(plane.centre[0]);
    arc.second = start.*plane.second + offset(plane.centre[1]);
  }
  const Joints end = arc_words();
  if (auto wrong = arc_is_wrong(start, end, arc)) return wrong;
  const ArcWay way(start, end, arc);
  if (posted_ && way.turn() > kHalfRound)
    return "an arc of more than half a circle, which no posted program has: is its direction lost?";
  const Joints slides = at_;
  const int pieces = way.pieces();
  for (int i = 1; i <= pieces; ++i) {
    const Joints at = way.at(static_cast<double>(i) / pieces);
    const Vec3 tip = plane_ ? plane_->told.origin + plane_->told.frame * Vec3{at.x, at.y, at.z} : Vec3{};
    at_ = i == pieces ? slides : plane_ ? frames_.slide_words({tip.x, tip.y, tip.z, at.a, at.c}) : at;
    put(blocks, false, pieces, i < pieces);
  }
  return std::nullopt;
}

}  // namespace tiltfeed::sim
