// Declarations of palpate.h for C# (Unity, .NET, Mono), ABI 1. MIT licence.
// The native library is palpate_engine (libpalpate_engine.so, palpate_engine.dll). Structures are
// blittable: no marshalling and no garbage in the force thread. Sizes, in this order, are checked
// against the header by the project's tests (check_csharp.c). C# 7.0 is enough.
//
//   size palpate_asset 2048, palpate_contact 31744, palpate_pose 56, palpate_tool 408,
//   size palpate_input 160, palpate_output 352, palpate_info 136, palpate_mesh 96
using System;
using System.Runtime.InteropServices;

public static unsafe class Palpate
{
    const string Library = "palpate_engine";
    public const int Abi = 1, Ok = 0, MaxProfile = 48, MaxBalls = 8; // balls of one tool, and of all ticked together
    public const int Air = 0, Stick = 1, Slip = 2; // Output.State

    [StructLayout(LayoutKind.Sequential)] public struct Asset { public fixed ulong Storage[256]; }
    [StructLayout(LayoutKind.Sequential)] public struct Contact { public fixed ulong Storage[3968]; }

    [StructLayout(LayoutKind.Sequential)]
    public struct Pose
    {
        public fixed double PositionM[3];
        public fixed double OrientationWxyz[4]; // unit quaternion
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Tool
    {
        public int Balls, Reserved0;
        public fixed double CentreM[3 * MaxBalls]; // x, y, z of each, in the tool's frame
        public fixed double RadiusM[MaxBalls];     // 0: a tip
        public double DampingNsM, DamperDepthM;
        public double LateralDampingNsM, MaxForceN, RampS;
        public fixed ulong BallAsset[MaxBalls]; // Asset* of palpate_indenter_open for each ball; 0: the asset that is ticked
        public fixed double Reserved[5];
    }

    // How a tool ends that is not the ball of the asset; BallIndenter() makes one of another radius.
    [StructLayout(LayoutKind.Sequential)]
    public struct Indenter
    {
        public double RoundEndM;
        public int Points, Reserved0;
        public fixed double RM[MaxProfile];
        public fixed double Slope[MaxProfile];
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Input
    {
        public Pose Tool, Body;
        public double DtS;
        public int WantsTangent;
        public fixed int Reserved[9];
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Output
    {
        public fixed double ForceOnToolN[3];
        public fixed double TorqueOnToolNm[3];
        public fixed double ContactM[3];
        public fixed double Normal[3];
        public fixed double Weight[3];
        public double NormalM, LateralM, StoredJ, DissipatedJ, RefusedJ, DampedJ;
        public fixed double StiffnessNM[9];
        public long RefusedTicks;
        public int Triangle, State;
        public uint Flags;
        public int Status;
        public fixed double DeflectionM[3];
        public fixed double ActsAtM[3];
        public double ApproachMS;
        public uint Events;  // 1 touched, 2 released
        public int Touching; // balls in contact
        public fixed uint Reserved[6];
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Info
    {
        public int Vertices, Triangles;
        public double MaxStepM, ProbeRadiusM;
        public fixed double BoxMinM[3];
        public fixed double BoxMaxM[3];
        public double RangeM;
        public ulong Checksum;
        public byte* Law;
        public int HasGuard, HasShape, Relaxes, Softens, Couples, VisualVertices;
        public byte* MetaJson; // not terminated
        public ulong MetaBytes;
    }

    [StructLayout(LayoutKind.Sequential)]
    public struct Mesh
    {
        public int Vertices, Triangles;
        public fixed double OriginM[3];
        public float* VertexM, InwardNormal; // 3 a vertex
        public byte* Covered;
        public int* Triangle; // 3 corners, counter-clockwise from outside
        public fixed uint Reserved[8];
    }

    [DllImport(Library)] static extern int palpate_sizes_fit(int abi, uint* bytes);
    [DllImport(Library)] static extern IntPtr palpate_sentence(int status);
    // bytes: at a multiple of 8 (palpate_copy_aligned), unchanged while in use.
    [DllImport(Library)] public static extern int palpate_open(Asset* asset, void* bytes, ulong size);
    [DllImport(Library)] public static extern void palpate_close(Asset* asset);
    [DllImport(Library)]
    public static extern void* palpate_copy_aligned(void* room, ulong roomBytes, void* bytes, ulong size);
    [DllImport(Library)] public static extern int palpate_describe(Asset* asset, Info* info);
    [DllImport(Library)] public static extern int palpate_read_mesh(Asset* asset, Mesh* mesh);
    // memory: palpate_indenter_bytes, at a multiple of 8; `opened` is used in place of the asset.
    [DllImport(Library)] public static extern ulong palpate_indenter_bytes(Asset* asset);
    [DllImport(Library)]
    public static extern int palpate_indenter_open(Asset* opened, Asset* asset, Indenter* indenter, void* memory,
                                                   ulong bytes);
    [DllImport(Library)] public static extern int palpate_start(Contact* contact, Tool* tool);
    [DllImport(Library)] public static extern int palpate_release(Contact* contact);
    // contacts, inputs and outputs: arrays of count, always the same tools in the same order.
    [DllImport(Library)]
    public static extern int palpate_tick(Asset* asset, Contact* contacts, int count, Input* inputs, Output* outputs);
    // For the thread that draws: contacts are copies; displacementM has three floats a vertex.
    [DllImport(Library)]
    public static extern int palpate_deform(Asset* asset, Contact* contacts, int count, int first, int vertices,
                                            float* displacementM);
    // Vertices of a mesh of one's own (Info.VisualVertices): displacementM of the whole surface, or null at rest.
    [DllImport(Library)]
    public static extern int palpate_place_visual(Asset* asset, float* displacementM, int first, int vertices,
                                                  float* placeM);

    // A tool of one ball at its origin; radius 0: a tip.
    public static Tool Ball(double radiusM)
    {
        Tool tool = new Tool { Balls = 1 };
        tool.RadiusM[0] = radiusM;
        return tool;
    }

    public static Indenter BallIndenter(double radiusM)
    {
        return new Indenter { RoundEndM = radiusM };
    }

    // Ok when the library has this file's structures; ask before anything else.
    public static int HeaderFits()
    {
        uint* bytes = stackalloc uint[8];
        bytes[0] = (uint)sizeof(Asset);
        bytes[1] = (uint)sizeof(Contact);
        bytes[2] = (uint)sizeof(Pose);
        bytes[3] = (uint)sizeof(Tool);
        bytes[4] = (uint)sizeof(Input);
        bytes[5] = (uint)sizeof(Output);
        bytes[6] = (uint)sizeof(Info);
        bytes[7] = (uint)sizeof(Mesh);
        return palpate_sizes_fit(Abi, bytes);
    }

    public static string Sentence(int status)
    {
        return Marshal.PtrToStringAnsi(palpate_sentence(status));
    }
}
