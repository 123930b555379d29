#include <gtest/gtest.h>
#include <ctime>
#include <cstdio>
#include "libfem/solve/simulator.hpp"
#include "libfem/mesh/grade/boundary.hpp"
#include "test_meshes.hpp"
using namespace palpate; using namespace palpate::fem;
static double cpu(){timespec t;clock_gettime(CLOCK_THREAD_CPUTIME_ID,&t);return t.tv_sec+1e-9*t.tv_nsec;}
static double env(const char* n,double d){return getenv(n)?atof(getenv(n)):d;}
TEST(Axi, press){
  const double S=1e-3; int n=(int)env("N",6); double nu=env("NU",0.45);
  // square to disc (concentric map)
  auto map=[&](const Vec3&p){ double a=2*p.x()-1,b=2*p.y()-1; double m=std::max(std::abs(a),std::abs(b)), l=std::hypot(a,b); double f=l>0? m/l:1; double w=m*m; f=(1-w)*1+w*f; 
     return Vec3(60*S*a*f,60*S*b*f,-40*S*(1-p.z())); };
  SimulationSetup s; s.volume=grid_tets(n,n,n/2,map);
  for(int i=0;i<s.volume.nodes.rows();++i) s.is_held.push_back(s.volume.nodes(i,2)<-39.999*S);
  TetMesh finer=grid_tets(6*n,6*n,n/2,map);
  s.surface={finer.nodes,boundary_triangles(finer.tets)};
  s.materials={{"neo-hookean",{10e3,nu}}}; s.probe_radius_m=10*S; s.friction=env("MU",0);
  auto&o=s.options; o.element_size=env("H",o.element_size); o.growth=env("G",o.growth); o.reach=env("REACH",o.reach); o.twin_ratio=env("TWIN",o.twin_ratio);
  o.equilibrium.residual=env("TOL",o.equilibrium.residual); o.equilibrium.linear=env("LIN",o.equilibrium.linear); o.equilibrium.most_pcg=(int)env("PCG",o.equilibrium.most_pcg);
  o.equilibrium.model.residual=env("MODEL",o.equilibrium.model.residual); o.equilibrium.contact_margin=env("MARGIN",o.equilibrium.contact_margin); o.contact.curvature=env("CURV",1); o.equilibrium.stale_pcg=(int)env("STALE",10); o.contact.tangential=env("KT",o.contact.tangential); o.equilibrium.trusted=env("TRUST",0.05); o.contact.stiffness=env("K",o.contact.stiffness); o.contact.rounding=env("ROUND",o.contact.rounding);
  Simulator sim(s);
  Experiments e; e.depth_m=10*S; e.press_steps=(int)env("STEPS",10);
  if(env("DRAG",0)>0){ e.drag_depths_m={4*S,8*S}; e.drag_distance_m=8*S; }
  double t0=cpu();
  auto r=sim.press_and_drag(Vec3(0,0,0),-Vec3::UnitZ(),e);
  double t1=cpu()-t0;
  const double F45[]={0.056213,0.162001,0.300782,0.465666,0.652051,0.855974,1.074112,1.303358,1.540461,1.782624};
  const double F49[]={0.058636,0.168528,0.312130,0.482380,0.674115,0.883201,1.106157,1.339524,1.579860,1.824296};
  for(auto&row:r.rows){ int k=(int)std::lround(row.deflection.norm()*1e3); bool p=row.kind==ExperimentKind::press;
    double ref=p&&k>=1&&k<=10?(nu>0.47?F49:F45)[k-1]:NAN; Vec3 f=row.force;
    printf("%d/%d st %d d (%.2f %.2f %.2f) F (%.5f %.5f %.5f) err %.4f  true %+.2f %%  est %.2f %%\n",row.experiment,row.step,(int)row.status,row.deflection.x()*1e3,row.deflection.y()*1e3,row.deflection.z()*1e3,f.x(),f.y(),f.z(),row.force_error,100*(-f.z()/ref-1),100*row.force_error/f.norm()); }
  auto c=r.cost; auto pr=[](const char*w,int nn,SolverCounts k){printf("%s nodes %d newton %d pcg %d model %d fac %d(%d) ls %d\n",w,nn,k.newton,k.pcg,k.model,k.factorizations,k.failed_factorizations,k.backtracks);};
  pr("fine",c.nodes,c.solver); pr("twin",c.twin_nodes,c.twin_solver); printf("touch %.3e cpu %.3f\n",r.touch_offset_m,t1);
}
