// Writes the CAD files of the tests, by OpenCASCADE's own writers: cad_files FOLDER. What their surfaces are
// is stated in tests/cad/cad_shapes.h.

#include <BRepAlgoAPI_Cut.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepGProp.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <GProp_GProps.hxx>
#include <Geom_BezierSurface.hxx>
#include <IGESCAFControl_Writer.hxx>
#include <IGESControl_Controller.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <STEPControl_Controller.hxx>
#include <Standard_Failure.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <cmath>
#include <gp_Circ.hxx>
#include <gp_Pln.hxx>

#include <cstdio>
#include <string>

#include "tests/cad/cad_shapes.h"

namespace {

using namespace tiltfeed::cad_shapes;

Handle(TDocStd_Document) new_document() {
  Handle(TDocStd_Document) document;
  XCAFApp_Application::GetApplication()->NewDocument("MDTV-XCAF", document);
  return document;
}

TDF_Label add(const Handle(TDocStd_Document) & document, const TopoDS_Shape& shape, const char* name) {
  const TDF_Label label = XCAFDoc_DocumentTool::ShapeTool(document->Main())->AddShape(shape, false);
  TDataStd_Name::Set(label, name);
  return label;
}

void colour(const Handle(TDocStd_Document) & document, const TopoDS_Shape& shape, double r, double g,
            double b) {
  XCAFDoc_DocumentTool::ColorTool(document->Main())
      ->SetColor(shape, Quantity_Color(r, g, b, Quantity_TOC_sRGB), XCAFDoc_ColorSurf);
}

void write_step(const Handle(TDocStd_Document) & document, const std::string& path, const char* unit = "MM") {
  Interface_Static::SetCVal("write.step.unit", unit);
  STEPCAFControl_Writer writer;
  writer.SetNameMode(true), writer.SetColorMode(true);
  writer.Transfer(document, STEPControl_AsIs);
  if (writer.Write(path.c_str()) != IFSelect_RetDone) throw Standard_Failure(path.c_str());
}

void write_step(const TopoDS_Shape& shape, const std::string& path, const char* unit = "MM") {
  const Handle(TDocStd_Document) document = new_document();
  add(document, shape, "part");
  write_step(document, path, unit);
}

/// `brep`: 1 solids, 0 faces that stand loose.
void write_iges(const TopoDS_Shape& shape, const std::string& path, const char* unit, int brep) {
  const Handle(TDocStd_Document) document = new_document();
  add(document, shape, "part");
  Interface_Static::SetCVal("write.iges.unit", unit);
  Interface_Static::SetIVal("write.iges.brep.mode", brep);
  IGESCAFControl_Writer writer;
  if (!writer.Transfer(document) || !writer.Write(path.c_str())) throw Standard_Failure(path.c_str());
}

TopoDS_Face face_at(const TopoDS_Shape& shape, int number) {
  TopExp_Explorer e(shape, TopAbs_FACE);
  for (; number > 0; --number) e.Next();
  return TopoDS::Face(e.Current());
}

/// A block whose top is the spline patch.
TopoDS_Shape spline_block() {
  TColgp_Array2OfPnt poles(1, kPoles, 1, kPoles);
  for (int i = 0; i < kPoles; ++i)
    for (int j = 0; j < kPoles; ++j)
      poles.SetValue(i + 1, j + 1, gp_Pnt(kPatchStep * i, kPatchStep * j, kPoleHeight[i][j]));
  const Handle(Geom_BezierSurface) patch = new Geom_BezierSurface(poles);
  const TopoDS_Face top = BRepBuilderAPI_MakeFace(patch, 1e-6);
  return BRepPrimAPI_MakePrism(top, gp_Vec(0, 0, -20)).Shape();
}

/// A flat ring.
TopoDS_Shape ring(double inner) {
  const auto circle = [](double radius) {
    const gp_Circ round(gp_Ax2(gp_Pnt(0, 0, 0), gp::DZ()), radius);
    return BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(round)).Wire();
  };
  BRepBuilderAPI_MakeFace face(gp_Pln(gp::XOY()), circle(kRingOuter));
  face.Add(TopoDS::Wire(circle(inner).Reversed()));
  return face.Face();
}

void write_all(const std::string& folder) {
  write_step(ring(kWasherInner), folder + "/washer.step");
  write_step(ring(kRingInner), folder + "/ring.step");
  write_step(BRepPrimAPI_MakeCylinder(kCylinderRadius, 30).Shape(), folder + "/cylinder.step");
  write_step(BRepPrimAPI_MakeSphere(kSphereRadius).Shape(), folder + "/sphere.step");
  write_step(BRepPrimAPI_MakeTorus(kTorusMajor, kTorusMinor).Shape(), folder + "/torus.step");
  write_step(BRepPrimAPI_MakeCone(kConeLower, 5, 20).Shape(), folder + "/cone.step");
  write_step(spline_block(), folder + "/spline.step");
  const TopoDS_Shape box = BRepPrimAPI_MakeBox(40, 30, 20).Shape();
  write_step(box, folder + "/box.step");
  write_step(box, folder + "/box_inch.step", "INCH");
  write_iges(box, folder + "/box.iges", "MM", 1);
  write_iges(box, folder + "/box_inch.iges", "INCH", 0);
  const TopoDS_Shape pocket =
      BRepAlgoAPI_Cut(box, BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(20, 15, 8), gp::DZ()), 10, 30).Shape())
          .Shape();
  write_iges(pocket, folder + "/pocket.iges", "MM", 0);
  write_step(pocket, folder + "/pocket.step");

  // A step whose upper level, z = 20 over x < 20, is red, and whose lower one, z = 10, is green.
  const TopoDS_Shape step =
      BRepAlgoAPI_Cut(box, BRepPrimAPI_MakeBox(gp_Pnt(20, 0, 10), gp_Pnt(40, 30, 20)).Shape()).Shape();
  const Handle(TDocStd_Document) stepped = new_document();
  add(stepped, step, "step");
  for (TopExp_Explorer e(step, TopAbs_FACE); e.More(); e.Next()) {
    GProp_GProps properties;
    BRepGProp::SurfaceProperties(e.Current(), properties);
    const gp_Pnt middle = properties.CentreOfMass();
    if (middle.Z() > 19.9) colour(stepped, e.Current(), 1.0, 0.0, 0.0);
    if (std::abs(middle.Z() - 10.0) < 0.1 && middle.X() > 20.1 && middle.X() < 39.9 && middle.Y() > 0.1 &&
        middle.Y() < 29.9)
      colour(stepped, e.Current(), 0.0, 1.0, 0.0);
  }
  write_step(stepped, folder + "/step.step");

  // An assembly: the block twice, a sphere beside it; one face red, the sphere a mixed green.
  const Handle(TDocStd_Document) document = new_document();
  const Handle(XCAFDoc_ShapeTool) tool = XCAFDoc_DocumentTool::ShapeTool(document->Main());
  const TopoDS_Shape ball = BRepPrimAPI_MakeSphere(gp_Pnt(100, 0, 0), 6).Shape();
  const TDF_Label block = add(document, box, "block"), round = add(document, ball, "knob"),
                  all = tool->NewShape();
  TDataStd_Name::Set(all, "assembly");
  gp_Trsf away;
  away.SetTranslation(gp_Vec(0, 60, 0));
  for (const gp_Trsf& at : {gp_Trsf(), away}) tool->AddComponent(all, block, TopLoc_Location(at));
  tool->AddComponent(all, round, TopLoc_Location());
  tool->UpdateAssemblies();
  // Faces of a box in this order: x low and high, y low and high, z low and high.
  colour(document, face_at(box, 5), 1.0, 0.0, 0.0);
  colour(document, ball, 0.0, kMixedGreen / 255.0, 0.0);
  write_step(document, folder + "/assembly.step");
  // The same with each product in a file of its own: apart_block.stp, apart_knob.stp.
  STEPCAFControl_Writer apart;
  if (!apart.Transfer(document, STEPControl_AsIs, (folder + "/apart_").c_str()) ||
      apart.Write((folder + "/apart.step").c_str()) != IFSelect_RetDone)
    throw Standard_Failure("apart.step");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: cad_files FOLDER\n"), 2;
  try {
    STEPControl_Controller::Init(), IGESControl_Controller::Init();
    Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer));
    write_all(argv[1]);
  } catch (const Standard_Failure& failure) {
    return std::fprintf(stderr, "cad_files: %s\n", failure.GetMessageString()), 1;
  }
  return 0;
}
