#pragma once
// ZIP archives as the format's text says [APPNOTE 6.3.10], written by hand: no code of the reader's.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace tiltfeed {

inline void put_whole(std::string& out, std::uint64_t value, int bytes) {
  for (; bytes > 0; --bytes, value >>= 8) out += static_cast<char>(value & 0xff);
}

/// Bit by bit.
inline std::uint32_t zip_check_sum(const std::string& text) {
  std::uint32_t sum = 0xffffffffu;
  for (const char c : text) {
    sum ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) sum = (sum & 1u) != 0 ? sum >> 1 ^ 0xedb88320u : sum >> 1;
  }
  return ~sum;
}

/// One entry: its text, and how it lies in the archive.
struct ZipText {
  std::string name, text;
  int method = 0;
  std::string packed = {};  ///< empty: the text itself
  int flags = 0;
  std::int64_t says_size = -1;  ///< -1: the true one
};

inline std::string zip_of(const std::vector<ZipText>& entries, const std::string& remark = "") {
  std::string out, directory;
  for (const ZipText& entry : entries) {
    const std::string& packed = entry.packed.empty() ? entry.text : entry.packed;
    std::string common;
    put_whole(common, 20, 2), put_whole(common, static_cast<std::uint64_t>(entry.flags), 2);
    put_whole(common, static_cast<std::uint64_t>(entry.method), 2), put_whole(common, 0, 4);
    put_whole(common, zip_check_sum(entry.text), 4), put_whole(common, packed.size(), 4);
    put_whole(common, entry.says_size < 0 ? entry.text.size() : static_cast<std::uint64_t>(entry.says_size),
              4);
    put_whole(common, entry.name.size(), 2), put_whole(common, 0, 2);
    directory += std::string("PK\x01\x02\x14\x00", 6) + common;
    put_whole(directory, 0, 10), put_whole(directory, out.size(), 4);
    directory += entry.name;
    out += "PK\x03\x04" + common + entry.name + packed;
  }
  const std::size_t at = out.size();
  out += directory + "PK\x05\x06";
  put_whole(out, 0, 4), put_whole(out, entries.size(), 2), put_whole(out, entries.size(), 2);
  put_whole(out, directory.size(), 4), put_whole(out, at, 4), put_whole(out, remark.size(), 2);
  return out + remark;
}

inline const char* const kMfRelations =
    "<?xml version=\"1.0\"?><Relationships "
    "xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">"
    "<Relationship Target=\"/3D/part.model\" Id=\"r0\" "
    "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>";

/// An archive whose model is this.
inline std::string three_mf_of(const std::string& model) {
  return zip_of({{"_rels/.rels", kMfRelations}, {"3D/part.model", model}});
}

/// `resources` and `build` within a model of that unit.
inline std::string mf_model(const std::string& resources, const std::string& build,
                            const std::string& attributes = "") {
  return "<?xml version=\"1.0\"?>\n<model "
         "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
         "xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\" "
         "xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" "
         "xmlns:b=\"http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02\" " +
         attributes + ">\n<resources>\n" + resources + "</resources>\n<build>\n" + build + "</build></model>";
}

/// A tetrahedron with legs of 1, its mesh.
inline const char* const kMfCorner =
    "<mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" z=\"0\"/><vertex x=\"0\" "
    "y=\"1\" z=\"0\"/>"
    "<vertex x=\"0\" y=\"0\" z=\"1e0\"/></vertices><triangles><triangle v1=\"0\" v2=\"2\" v3=\"1\"/>"
    "<triangle v1=\"0\" v2=\"1\" v3=\"3\"/><triangle v1=\"1\" v2=\"2\" v3=\"3\"/><triangle v1=\"0\" v2=\"3\" "
    "v3=\"2\"/>"
    "</triangles></mesh>";

}  // namespace tiltfeed
