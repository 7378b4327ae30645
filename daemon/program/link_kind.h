#pragma once
// The kinds of controllers that programs are sent to.

namespace tiltfeed::daemon {

/// A journal keeps these as numbers: new ones at the end.
enum class LinkKind { kGrbl, kRepRap, kDrip, kModbusTcp, kModbusRtu, kDriveTcp, kDriveRtu };
constexpr bool is_ring(LinkKind kind) { return kind == LinkKind::kModbusTcp || kind == LinkKind::kModbusRtu; }
constexpr bool is_drive(LinkKind kind) { return kind == LinkKind::kDriveTcp || kind == LinkKind::kDriveRtu; }
/// Modbus RTU, whatever the registers mean.
constexpr bool is_rtu(LinkKind kind) { return kind == LinkKind::kModbusRtu || kind == LinkKind::kDriveRtu; }

}  // namespace tiltfeed::daemon
