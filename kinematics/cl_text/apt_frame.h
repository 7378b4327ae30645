#pragma once
// The frame in which an APT file states its points.

#include <optional>
#include <string>

#include "kinematics/basics/geometry.h"
#include "kinematics/cl_text/apt_record.h"

namespace tiltfeed {

/// A point p and a direction u of the file are origin + turn p and turn u of the part.
struct AptFrame {
  Rotation turn;
  Vec3 origin;  ///< mm
};

/// MSYS/x,y,z,xi,xj,xk,yi,yj,yk: origin and two axes of the frame of the points, as NX states them.
AptVerdict read_msys(const AptRecord& record, double unit_mm, AptFrame& frame);
/// CSYS/ of twelve numbers, three rows of turn and origin: where an operation's set-up stands.
AptVerdict read_csys(const AptRecord& record, double unit_mm, AptFrame& frame);

}  // namespace tiltfeed
