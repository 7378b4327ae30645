#include "daemon/mtconnect/data_items.h"

#include <cctype>

namespace tiltfeed::daemon {
namespace {

constexpr const char* kNames[] = {"SAMPLE", "EVENT", "CONDITION"};
using enum ItemCategory;

/// The letters of the rotary axes that are there.
std::vector<std::string> rotary_letters(const MachineModel& machine) {
  std::vector<std::string> letters;
  for (const RotaryAxis* const axis : {&machine.tilt, &machine.rotary})
    if (axis->present) letters.emplace_back(1, axis->letter);
  return letters;
}

/// An ID of XML that needs no escapes: begins with a letter.
std::string token(const std::string& name) {
  std::string out;
  for (const char c : name)
    out += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' ? c : '-';
  return out.empty() ? "machine" : std::isalpha(static_cast<unsigned char>(out[0])) != 0 ? out : "m-" + out;
}

/// Of an element: agents that hear several machines have one document for all, and an id stands there once.
std::string id_and_name(const std::string& device, const std::string& name) {
  return " id=\"" + device + "-" + name + "\" name=\"" + name + "\"";
}

std::string attribute(const char* name, const std::string& value) {
  return value.empty() ? std::string() : std::string(" ") + name + "=\"" + value + "\"";
}

/// The items of one component, as an XML element of so much indent.
std::string items_of(const std::vector<DataItem>& items, const std::string& device,
                     const std::string& component, const std::string& indent) {
  std::string out = indent + "<DataItems>\n";
  for (const DataItem& item : items) {
    if (item.component != component) continue;
    // Places are those of the program: the machine's own are not known to who sends it.
    const bool placed = item.type == "POSITION" || item.type == "PATH_POSITION" || item.type == "ANGLE";
    out += indent + "  <DataItem" + attribute("category", kNames[static_cast<int>(item.category)]) +
           id_and_name(device, item.id) + attribute("type", item.type) + attribute("subType", item.sub_type) +
           attribute("units", item.units) + attribute("nativeUnits", item.units) +
           attribute("coordinateSystem", placed ? "WORK" : "") + "/>\n";
  }
  return out + indent + "</DataItems>\n";
}

std::string axis_element(const std::vector<DataItem>& items, const std::string& device, const char* kind,
                         const std::string& axis) {
  const std::string indent(12, ' ');
  return indent + "<" + kind + id_and_name(device, axis) + ">\n" +
         items_of(items, device, axis, indent + "  ") + indent + "</" + kind + ">\n";
}

}  // namespace

std::vector<DataItem> data_items(const MachineModel& machine) {
  std::vector<DataItem> items = {
      {"device", kEvent, "avail", "AVAILABILITY", "", ""},
      {"controller", kEvent, "mode", "CONTROLLER_MODE", "", ""},
      {"controller", kCondition, "comms", "COMMUNICATIONS", "", ""},
      {"controller", kCondition, "logic", "LOGIC_PROGRAM", "", ""},
      {"controller", kCondition, "system", "SYSTEM", "", ""},
      {"path", kEvent, "execution", "EXECUTION", "", ""},
      {"path", kEvent, "program", "PROGRAM", "", ""},
      {"path", kEvent, "line", "LINE_NUMBER", "ABSOLUTE", ""},
      {"path", kEvent, "block", "BLOCK", "", ""},
      {"path", kEvent, "parts", "PART_COUNT", "ALL", ""},
      {"path", kEvent, "feed_override", "PATH_FEEDRATE_OVERRIDE", "PROGRAMMED", ""},
      {"path", kEvent, "rapid_override", "PATH_FEEDRATE_OVERRIDE", "RAPID", ""},
      {"path", kSample, "feedrate", "PATH_FEEDRATE", "ACTUAL", "MILLIMETER/SECOND"},
      {"path", kSample, "position", "PATH_POSITION", "ACTUAL", "MILLIMETER_3D"},
      {"path", kCondition, "motion", "MOTION_PROGRAM", "", ""},
  };
  for (const char* const axis : {"X", "Y", "Z"})
    items.push_back({axis, kSample, std::string(axis) + "_position", "POSITION", "ACTUAL", "MILLIMETER"});
  for (const std::string& axis : rotary_letters(machine))
    items.push_back({axis, kSample, axis + "_angle", "ANGLE", "ACTUAL", "DEGREE"});
  items.push_back({"S", kEvent, "S_mode", "ROTARY_MODE", "", ""});
  items.push_back({"S", kSample, "S_speed", "ROTARY_VELOCITY", "COMMANDED", "REVOLUTION/MINUTE"});
  items.push_back({"S", kEvent, "S_override", "ROTARY_VELOCITY_OVERRIDE", "", ""});
  return items;
}

std::string device_file(const MachineModel& machine, const std::string& service) {
  const std::vector<DataItem> items = data_items(machine);
  const std::string device = token(service.empty() ? machine.name : service);
  std::string out =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<MTConnectDevices xmlns=\"urn:mtconnect.org:MTConnectDevices:2.2\">\n"
      "  <Header creationTime=\"2026-01-01T00:00:00Z\" sender=\"tiltfeed\" instanceId=\"1\" version=\"2.2\""
      " bufferSize=\"131072\" assetBufferSize=\"1\" assetCount=\"0\""
      " deviceModelChangeTime=\"2026-01-01T00:00:00Z\"/>\n"
      "  <Devices>\n"
      "    <Device id=\"" +
      device + "\" name=\"" + device + "\" uuid=\"tiltfeed-" + device + "\">\n";
  out += items_of(items, device, "device", std::string(6, ' '));
  out += "      <Components>\n        <Axes" + id_and_name(device, "axes") + ">\n          <Components>\n";
  for (const char* const axis : {"X", "Y", "Z"}) out += axis_element(items, device, "Linear", axis);
  for (const std::string& axis : rotary_letters(machine)) out += axis_element(items, device, "Rotary", axis);
  out += axis_element(items, device, "Rotary", "S");
  out += "          </Components>\n        </Axes>\n        <Controller" + id_and_name(device, "controller") +
         ">\n";
  out += items_of(items, device, "controller", std::string(10, ' '));
  out += "          <Components>\n            <Path" + id_and_name(device, "path") + ">\n";
  out += items_of(items, device, "path", std::string(14, ' '));
  return out +
         "            </Path>\n          </Components>\n        </Controller>\n      </Components>\n"
         "    </Device>\n  </Devices>\n</MTConnectDevices>\n";
}

}  // namespace tiltfeed::daemon
