// ControlReader's tilted planes: the rotaries stand, and X Y Z are the tip's in the plane.

#include <algorithm>
#include <cmath>

#include "kinematics/basics/decimal.h"
#include "sim/control/control_reader.h"

namespace tiltfeed::sim {
namespace {

// Of the last decimal of an angle: those of the plane and of both rotaries are rounded.
constexpr double kRounded = 3.0;

}  // namespace

/// The codes and names of planes.
ControlReader::Wrong ControlReader::planes(const ControlWords& words) {
  if (words.has_g(690) || words.has_g(2550) || words.named("CYCLE800()")) plane_.reset();
  if (words.has_g(2540)) return begin_plane({frames_.slides(at_), {}, 0}, true);
  if (words.has_g(531)) return turn_to_plane();
  for (std::size_t i = 0; i < words.name_count; ++i) {
    if (!words.names[i].starts_with("CYCLE800(") || words.names[i] == "CYCLE800()") continue;
    ReadPlane plane;
    if (auto wrong = read_cycle800(words.names[i], plane)) return wrong;
    return begin_plane(plane, true);
  }
  return std::nullopt;
}

/// `at_once`: the plane's words turn the rotaries, or would; else G53.1 does.
ControlReader::Wrong ControlReader::begin_plane(const ReadPlane& plane, bool at_once) {
  if (tcp_) return "a tilted plane under TCP is refused";
  if (!known_[3] || !known_[4]) return "a tilted plane begins before the rotaries are at their place";
  plane_ = Plane{plane, false, {}};
  plane_->told.origin = plane.origin * unit_;
  return at_once ? turn_to_plane() : std::nullopt;
}

/// The control turns the rotaries until the tool is along the plane's Z: they have to stand there already.
ControlReader::Wrong ControlReader::turn_to_plane() {
  if (!plane_) return "G53.1 without G68.2";
  const Rotation& frame = plane_->told.frame;
  const Vec3 z{frame.rows[0].z, frame.rows[1].z, frame.rows[2].z};
  const double off = Angle::from_radians(angle_between(z, frames_.tool(at_))).degrees();
  if (off > kRounded / decimal_scale(angle_decimals_))
    return "the tool is " + decimal(off, 3) +
           " degrees off the plane's Z: the control would turn the rotaries, or the tool cuts at a slant";
  const double tilt = model_.tilt.present ? at_.a - model_.tilt.zero : 0.0;
  if (plane_->told.side * tilt < 0.0)
    return std::string("the plane's words say the other side for ") + model_.tilt.letter +
           ", and the control would turn the rotaries over to it";
  plane_->turned = true;
  return std::nullopt;
}

/// Axis words in the plane: the slides follow.
ControlReader::Wrong ControlReader::plane_place(const ControlWords& words) {
  if (!plane_->turned) return "axis words between G68.2 and G53.1";
  for (const char letter : {model_.tilt.letter, model_.rotary.letter})
    if (letter != kNoLetter && words.has(letter)) return "a rotary turns in a tilted plane";
  constexpr std::array<char, 3> kLetters{'X', 'Y', 'Z'};
  const bool all = std::all_of(kLetters.begin(), kLetters.end(), [&](char one) { return words.has(one); });
  if (!whole() && !all)
    return "the first block in a plane states not all of X Y Z, and the place is not known";
  const ReadPlane& told = plane_->told;
  if (!plane_->at) {
    const Joints tip = frames_.tip_words(at_);
    plane_->at = transposed(told.frame) * (Vec3{tip.x, tip.y, tip.z} - told.origin);
  }
  for (std::size_t i = 0; i < kLetters.size(); ++i) {
    if (!words.has(kLetters[i])) continue;
    double& place = i == 0 ? plane_->at->x : i == 1 ? plane_->at->y : plane_->at->z;
    place = words[kLetters[i]];
    if (counts_points_ && !words.has_point(kLetters[i])) place *= 1e-3;
    place *= unit_;
    known_[i] = true;
  }
  const Vec3 tip = told.origin + told.frame * *plane_->at;
  at_ = frames_.slide_words({tip.x, tip.y, tip.z, at_.a, at_.c});
  return std::nullopt;
}

ControlReader::Wrong ControlReader::plane_line(std::string_view line) {
  if (!tnc()) return "PLANE is no word of this control";
  if (line.starts_with("PLANE RESET")) {
    plane_.reset();
    if (line == "PLANE RESET STAY" || line == "PLANE RESET") return std::nullopt;
    return "a plane that ends with another word than STAY turns the rotaries by itself";
  }
  ReadPlane plane;
  if (auto wrong = read_plane_spatial(line, plane)) return wrong;
  return begin_plane(plane, true);
}

}  // namespace tiltfeed::sim
