#pragma once
// What an MTConnect agent is told of a machine: its data items, and the device file that declares them.

#include <string>
#include <vector>

#include "kinematics/machine/machine.h"

namespace tiltfeed::daemon {

enum class ItemCategory : unsigned char { kSample, kEvent, kCondition };

/// Names and units are those of MTConnect 2.2 (ANSI/MTC1.4, part 2 and 3).
struct DataItem {
  std::string component;  ///< id of the component that it belongs to; "device": the device itself
  ItemCategory category = ItemCategory::kEvent;
  std::string id;        ///< the key in the adapter's lines
  std::string type;      ///< as AVAILABILITY
  std::string sub_type;  ///< empty: none
  std::string units;     ///< of a sample, else empty
};

/// In a fixed order. Rotary axes that the machine does not have have no item.
std::vector<DataItem> data_items(const MachineModel& machine);

/// The agent's Devices.xml. Properties: valid by the schema MTConnectDevices_2.2; the device's name, its uuid
/// and the beginning of each id are `service`, else the machine's name, with '-' for what a name may not
/// have; each item's name is its key in the adapter's lines.
std::string device_file(const MachineModel& machine, const std::string& service);

}  // namespace tiltfeed::daemon
