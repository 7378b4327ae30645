#pragma once
// The words with which a control is told a tilted working plane, and the plane that they mean.

#include <optional>
#include <string>
#include <string_view>

#include "kinematics/basics/geometry.h"
#include "sim/control/control_words.h"

namespace tiltfeed::sim {

/// A plane in the part's frame with the table at home.
struct ReadPlane {
  Rotation frame;  ///< directions of the plane to the part's
  Vec3 origin;     ///< mm
  int side = 0;    ///< on which side of home the tilt stands, as the words say; 0: they do not
};

/// Each fills `plane`, or says what is wrong. Only what turns no axis by itself is taken.
/// G68.2 X Y Z I J K: about z, x, z, each turned by the ones before.
std::optional<std::string> read_g68_2(const ControlWords& words, ReadPlane& plane);
/// CYCLE800(FR,"TC",ST,MODE,X0,Y0,Z0,A,B,C,X1,Y1,Z1,DIR,FR_I), by axis.
std::optional<std::string> read_cycle800(std::string_view call, ReadPlane& plane);
/// The name in quotes that such a call has, without these; nothing: it has none.
std::optional<std::string_view> swivel_name(std::string_view call);
/// PLANE SPATIAL SPA SPB SPC STAY SEQ TABLE ROT: about fixed x, y, z.
std::optional<std::string> read_plane_spatial(std::string_view line, ReadPlane& plane);

}  // namespace tiltfeed::sim
