// As much of CHAI3D's interface as cPalpateBody.h uses, so that it compiles and runs without the
// SDK. Names and signatures are those of CHAI3D 3.3; nothing is drawn.
#pragma once

#include <memory>
#include <vector>

namespace chai3d {

constexpr int C_EFFECT_MAX_IDN = 16;

class cVector3d {
 public:
  cVector3d(double x = 0, double y = 0, double z = 0) : at_{x, y, z} {}
  double x() const { return at_[0]; }
  double y() const { return at_[1]; }
  double z() const { return at_[2]; }
  void set(const double& x, const double& y, const double& z) { *this = {x, y, z}; }
  void zero() { *this = {}; }

 private:
  double at_[3];
};

class cGenericObject;

class cGenericEffect {
 public:
  explicit cGenericEffect(cGenericObject* parent) : m_parent(parent) {}
  virtual ~cGenericEffect() = default;
  virtual bool computeForce(const cVector3d& position, const cVector3d& velocity,
                            const unsigned int& tool, cVector3d& force) = 0;
  cGenericObject* m_parent;
};

class cGenericObject {
 public:
  virtual ~cGenericObject() {
    for (cGenericEffect* effect : m_effects) delete effect;
  }
  bool addEffect(cGenericEffect* effect) { return m_effects.push_back(effect), true; }
  virtual void markForUpdate(bool /*children*/ = false, bool /*components*/ = true) {}
  std::vector<cGenericEffect*> m_effects;
};

struct cVertexArray {
  std::vector<cVector3d> m_localPos;
  void setLocalPos(unsigned int vertex, const double& x, const double& y, const double& z) {
    m_localPos[vertex].set(x, y, z);
  }
};

class cMesh : public cGenericObject {
 public:
  unsigned int newVertex(double x = 0, double y = 0, double z = 0) {
    m_vertices->m_localPos.emplace_back(x, y, z);
    return static_cast<unsigned int>(m_vertices->m_localPos.size() - 1);
  }
  unsigned int newTriangle(unsigned int, unsigned int, unsigned int) { return triangles++; }
  void computeAllNormals() {}
  std::shared_ptr<cVertexArray> m_vertices = std::make_shared<cVertexArray>();
  unsigned int triangles = 0;
};

}  // namespace chai3d
