#include "cad/shape/document_bodies.h"

#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Quantity_Color.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <algorithm>
#include <cmath>
#include <set>

namespace tiltfeed::cad {
namespace {

using Colour = std::optional<std::uint32_t>;

std::uint32_t packed(const Quantity_Color& colour) {
  // OpenCASCADE keeps linear light, files have what the screen shows.
  Standard_Real r = 0, g = 0, b = 0;
  colour.Values(r, g, b, Quantity_TOC_sRGB);
  const auto byte = [](double share) {
    return static_cast<std::uint32_t>(std::lround(std::clamp(share, 0.0, 1.0) * 255.0));
  };
  return byte(r) << 16 | byte(g) << 8 | byte(b);
}

std::string name_of(const TDF_Label& label) {
  Handle(TDataStd_Name) name;
  if (!label.FindAttribute(TDataStd_Name::GetID(), name)) return "";
  std::string text(static_cast<std::size_t>(name->Get().LengthOfCString()) + 1, '\0');
  Standard_PCharacter at = text.data();
  name->Get().ToUTF8CString(at);
  text.resize(std::char_traits<char>::length(text.c_str()));
  return text;
}

class Walk {
 public:
  Walk(const TDocStd_Document& document, const SourceOf& source_of)
      : shapes_(XCAFDoc_DocumentTool::ShapeTool(document.Main())),
        colours_(XCAFDoc_DocumentTool::ColorTool(document.Main())),
        source_of_(source_of) {}

  std::vector<LoadedBody> run() {
    TDF_LabelSequence free;
    shapes_->GetFreeShapes(free);
    for (const TDF_Label& label : free) visit(label, TopLoc_Location(), "", std::nullopt);
    make_unique();
    return std::move(bodies_);
  }

 private:
  Colour colour_of(const TopoDS_Shape& shape) const {
    Quantity_Color colour;
    for (const XCAFDoc_ColorType type : {XCAFDoc_ColorSurf, XCAFDoc_ColorGen})
      if (colours_->GetColor(shape, type, colour)) return packed(colour);
    return std::nullopt;
  }
  Colour colour_of(const TDF_Label& label) const {
    Quantity_Color colour;
    for (const XCAFDoc_ColorType type : {XCAFDoc_ColorSurf, XCAFDoc_ColorGen})
      if (colours_->GetColor(label, type, colour)) return packed(colour);
    return std::nullopt;
  }

  void visit(const TDF_Label& label, const TopLoc_Location& at, const std::string& instance, Colour above) {
    if (const Colour own = colour_of(label)) above = own;
    if (TDF_Label of; shapes_->GetReferredShape(label, of)) {
      visit(of, at * XCAFDoc_ShapeTool::GetLocation(label), name_of(label), above);
      return;
    }
    if (XCAFDoc_ShapeTool::IsAssembly(label)) {
      TDF_LabelSequence parts;
      XCAFDoc_ShapeTool::GetComponents(label, parts);
      for (const TDF_Label& part : parts) visit(part, at, "", above);
      return;
    }
    const std::string own = name_of(label);
    add(XCAFDoc_ShapeTool::GetShape(label), at, own.empty() ? instance : own, above);
  }

  void add(const TopoDS_Shape& shape, const TopLoc_Location& at, const std::string& product, Colour above) {
    std::vector<TopoDS_Shape> found;
    for (TopExp_Explorer e(shape, TopAbs_SOLID); e.More(); e.Next()) found.push_back(e.Current());
    for (TopExp_Explorer e(shape, TopAbs_SHELL, TopAbs_SOLID); e.More(); e.Next())
      found.push_back(e.Current());
    TopoDS_Compound loose;
    BRep_Builder builder;
    builder.MakeCompound(loose);
    bool any = false;
    for (TopExp_Explorer e(shape, TopAbs_FACE, TopAbs_SHELL); e.More(); e.Next(), any = true)
      builder.Add(loose, e.Current());
    if (any) found.push_back(loose);
    for (std::size_t i = 0; i < found.size(); ++i) {
      LoadedBody body;
      const ShapeSource source = source_of_(found[i]);
      body.product = product;
      body.name = found.size() == 1 && !product.empty() ? product : source.name;
      if (body.name.empty())
        body.name =
            (product.empty() ? "body" : product) + (found.size() == 1 ? "" : ":" + std::to_string(i + 1));
      body.closed = found[i].ShapeType() == TopAbs_SOLID;
      for (TopExp_Explorer e(found[i], TopAbs_SHELL); e.More(); e.Next())
        body.closed &= BRep_Tool::IsClosed(e.Current());
      const Colour own = colour_of(found[i]);
      for (TopExp_Explorer e(found[i], TopAbs_FACE); e.More(); e.Next()) {
        const ShapeSource of = source_of_(e.Current());
        const Colour colour = colour_of(e.Current());
        body.faces.push_back({of.name, colour ? colour : own ? own : above, of.entity});
      }
      body.shape = std::make_unique<TopoDS_Shape>(found[i].Moved(at));
      if (!body.faces.empty()) bodies_.push_back(std::move(body));
    }
  }

  void make_unique() {
    std::set<std::string> taken;
    for (LoadedBody& body : bodies_) {
      const std::string name = body.name;
      for (int i = 2; !taken.insert(body.name).second; ++i) body.name = name + " (" + std::to_string(i) + ")";
    }
  }

  Handle(XCAFDoc_ShapeTool) shapes_;
  Handle(XCAFDoc_ColorTool) colours_;
  const SourceOf& source_of_;
  std::vector<LoadedBody> bodies_;
};

}  // namespace

std::vector<LoadedBody> bodies_of(const TDocStd_Document& document, const SourceOf& source_of) {
  return Walk(document, source_of).run();
}

}  // namespace tiltfeed::cad
