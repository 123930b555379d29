// Stands in for SOFA where the tests compile docs/embedding/sofa: the names and signatures that it
// uses, without SOFA behind them.
#pragma once

#include <array>
#include <string>

using SReal = double;
#define SOFA_CLASS(kind, base) using ThisBase = base

namespace sofa {

template <class T>
struct InitData {
  T value;
};
template <class T>
class Data {
 public:
  explicit Data(const InitData<T>& init) : value_(init.value) {}
  const T& getValue() const { return value_; }
  void setValue(const T& value) { value_ = value; }

 private:
  T value_;
};

namespace defaulttype {
template <class Real>
struct SolidTypes {
  using Vec3 = std::array<Real, 3>;
  class SpatialVector {
   public:
    void setForce(const Vec3& v) { force_ = v; }
    void setTorque(const Vec3& v) { torque_ = v; }
    const Vec3& getForce() const { return force_; }

   private:
    Vec3 force_, torque_;
  };
  class Transform {
   public:
    Transform(const Vec3& origin, const std::array<Real, 4>& turn) : origin_(origin), turn_(turn) {}
    Vec3 getOrigin() const { return origin_; }
    const std::array<Real, 4>& getOrientation() const { return turn_; }

   private:
    Vec3 origin_;
    std::array<Real, 4> turn_;
  };
};
}  // namespace defaulttype

namespace component::haptics {
class ForceFeedback {
 public:
  using Solid = defaulttype::SolidTypes<SReal>;
  virtual ~ForceFeedback() = default;
  virtual void init() {}
  virtual void computeForce(SReal, SReal, SReal, SReal, SReal, SReal, SReal, SReal&, SReal&,
                            SReal&) = 0;
  virtual void computeWrench(const Solid::Transform&, const Solid::SpatialVector&,
                             Solid::SpatialVector&) = 0;
  Data<bool> d_activate{InitData<bool>{true}};

 protected:
  template <class T>
  InitData<T> initData(Data<T>*, const T& value, const char*, const char*) {
    return {value};
  }
};
}  // namespace component::haptics
}  // namespace sofa
