// The Unity package against the real library, by Mono: Test.exe ASSET.palp WALK [TWO.csv]. WALK is
// what walk_bits.c printed: x, y, z and the hash of palpate_output, 16 hex digits each, a tick a line;
// TWO.csv what it printed of two tools.
using System;
using System.Globalization;
using System.IO;
using System.Threading;
using UnityEngine;

public static unsafe class Test
{
    static int failures;

    static void Expect(bool holds, string claim)
    {
        if (holds) return;
        ++failures;
        Console.WriteLine("does not hold: " + claim);
    }

    sealed class Device : IPalpateDevice
    {
        public Vector3 At, Force, Torque;
        public Quaternion Turned = Quaternion.identity;
        public int Reads;
        public void Read(out Vector3 position, out Quaternion rotation)
        {
            ++Reads;
            position = At;
            rotation = Turned;
        }
        public void Write(Vector3 force, Vector3 torque)
        {
            Force = force;
            Torque = torque;
        }
    }

    static double FromBits(string hex)
    {
        return BitConverter.Int64BitsToDouble((long)ulong.Parse(hex, NumberStyles.HexNumber));
    }

    static void OutputsHaveTheBitsOfC(PalpateEngine engine, string[] walk)
    {
        PalpateContact contact = new PalpateContact(engine, Palpate.Ball(0));
        int touching = 0, different = 0;
        foreach (string line in walk)
        {
            string[] words = line.Split(' ');
            for (int i = 0; i < 3; ++i) contact.In->Tool.PositionM[i] = FromBits(words[i]);
            contact.Tick();
            ulong hash = 14695981039346656037;
            for (byte* b = (byte*)contact.Out; b < (byte*)(contact.Out + 1); ++b) hash = (hash ^ *b) * 1099511628211;
            if (hash.ToString("x16") != words[3]) ++different;
            if (contact.Out->State != Palpate.Air) ++touching;
        }
        Expect(different == 0, "every bit of every output is that of C; different: " + different);
        Expect(touching > 500, "the walk touches; ticks in contact: " + touching);
    }

    static Palpate.Tool Capsule(double radius)
    {
        Palpate.Tool capsule = Palpate.Ball(radius);
        capsule.Balls = 3;
        for (int i = 0; i < 3; ++i)
        {
            capsule.CentreM[3 * i] = radius * (i - 1);
            capsule.RadiusM[i] = radius;
        }
        return capsule;
    }

    // Mono drops the sign of -0.
    static double FromDigits(string digits)
    {
        double value = double.Parse(digits, CultureInfo.InvariantCulture);
        return value == 0 && digits[0] == '-' ? -0.0 : value;
    }
    static bool IsSame(double a, string digits)
    {
        return BitConverter.DoubleToInt64Bits(a) == BitConverter.DoubleToInt64Bits(FromDigits(digits));
    }

    // A ball and a capsule that turns, in one call: force and torque are those of C.
    static void TwoToolsHaveTheBitsOfC(PalpateEngine engine, string[] rows)
    {
        double radius = engine.Info.ProbeRadiusM;
        Palpate.Tool ball = Palpate.Ball(radius);
        ball.CentreM[2] = radius;
        PalpateContact contact = new PalpateContact(engine, ball, Capsule(radius));
        int different = 0, both = 0;
        for (int row = 1; row + 1 < rows.Length; row += 2)
        {
            for (int k = 0; k < 2; ++k)
            {
                string[] words = rows[row + k].Split(',');
                for (int i = 0; i < 3; ++i)
                    contact.In[k].Tool.PositionM[i] = FromDigits(words[1 + i]);
                for (int i = 0; i < 4; ++i)
                    contact.In[k].Tool.OrientationWxyz[(i + 1) % 4] = FromDigits(words[4 + i]);
            }
            contact.Tick();
            for (int k = 0; k < 2; ++k)
            {
                string[] words = rows[row + k].Split(',');
                for (int i = 0; i < 3; ++i)
                    if (!IsSame(contact.Out[k].ForceOnToolN[i], words[9 + i]) ||
                        !IsSame(contact.Out[k].TorqueOnToolNm[i], words[12 + i])) ++different;
            }
            if (contact.Out[0].State != Palpate.Air && contact.Out[1].Touching > 1) ++both;
        }
        Expect(different == 0, "forces and torques of two tools are those of C; different: " + different);
        Expect(both > 100, "both tools touch; ticks: " + both);
    }

    // Two tools of the scene, ticked by one of them, are two of one call.
    static void ToolsFeelEachOther(PalpateAsset asset)
    {
        Device[] device = { new Device(), new Device() };
        float radius = (float)asset.Engine.Info.ProbeRadiusM;
        PalpateTool finger = MakeTool(asset, device[1], radius, 0), thumb = MakeTool(asset, device[0], radius, 0);
        finger.body = thumb.body;
        thumb.others = new[] { finger };
        finger.balls = new[] { new Vector3(0, 0, 0), new Vector3(0, 0, radius) }; // along Palpate's y
        finger.OnEnable();
        thumb.OnEnable();
        Palpate.Tool two = Palpate.Ball(radius);
        two.Balls = 2;
        two.RadiusM[1] = radius;
        two.CentreM[4] = radius;
        PalpateContact direct = new PalpateContact(asset.Engine, Palpate.Ball(radius), two);
        Palpate.Info info = asset.Engine.Info;
        bool isEqual = true, isTouched = false;
        for (int tick = 0; tick < 400; ++tick)
        {
            for (int k = 0; k < 2; ++k)
            {
                device[k].At = PalpateAxes.ToUnity((info.BoxMinM[0] + info.BoxMaxM[0]) / 2 + 3 * radius * k,
                    (info.BoxMinM[1] + info.BoxMaxM[1]) / 2, info.BoxMaxM[2] + radius + 1e-3 - 1e-5 * tick);
                PalpateAxes.ToPalpate(device[k].At, direct.In[k].Tool.PositionM);
            }
            thumb.Step(0.001);
            direct.Tick();
            for (int k = 0; k < 2; ++k)
                isEqual &= device[k].Force.Equals(PalpateAxes.ToUnity(direct.Out[k].ForceOnToolN));
            isTouched |= direct.Out[0].State != Palpate.Air && direct.Out[1].Touching == 2;
        }
        Expect(isEqual && isTouched, "a tool ticks another one together with itself");
        thumb.OnDisable();
        Expect(device[1].Force.Equals(Vector3.zero), "none is left with a force");
    }

    static PalpateTool MakeTool(PalpateAsset asset, Device device, float radius, int rate)
    {
        PalpateBody body = new PalpateBody { asset = asset };
        body.OnEnable();
        return new PalpateTool { body = body, device = device, radius = radius, maxForce = 0, ramp = 0, rate = rate };
    }

    // y and z swapped on the way in and out, and nothing else: the floats' own bits.
    static void AToolSwapsAxes(PalpateAsset asset, string[] walk)
    {
        Device device = new Device();
        PalpateTool tool = MakeTool(asset, device, 0, 0);
        tool.OnEnable();
        PalpateContact direct = new PalpateContact(asset.Engine, Palpate.Ball(0));
        bool isEqual = true, isTouched = false;
        foreach (string line in walk)
        {
            string[] words = line.Split(' ');
            float x = (float)FromBits(words[0]), y = (float)FromBits(words[1]), z = (float)FromBits(words[2]);
            device.At = new Vector3(x, z, y);
            tool.Step(0.001);
            direct.In->Tool.PositionM[0] = x;
            direct.In->Tool.PositionM[1] = y;
            direct.In->Tool.PositionM[2] = z;
            direct.Tick();
            double* force = direct.Out->ForceOnToolN, torque = direct.Out->TorqueOnToolNm;
            isEqual &= device.Force.Equals(new Vector3((float)force[0], (float)force[2], (float)force[1]));
            isEqual &= device.Torque.Equals(new Vector3(-(float)torque[0], -(float)torque[2], -(float)torque[1]));
            isTouched |= force[2] != 0;
        }
        Expect(isEqual && isTouched, "a tool's force is the engine's with y and z swapped");
        device.At = new Vector3(float.NaN, 0, 0);
        tool.Step(0.001);
        tool.Update();
        Expect(Debug.Said.Count == 1 && device.Force.Equals(Vector3.zero), "a fault is said once, without force");
        tool.OnDisable();
    }

    // The whole scene turned and moved: the force turns with it, in Unity's own sense of rotation.
    static void ForcesTurnWithTheBody(PalpateAsset asset, string[] walk)
    {
        Device here = new Device(), there = new Device();
        PalpateTool still = MakeTool(asset, here, 0.004f, 0), moved = MakeTool(asset, there, 0.004f, 0);
        Quaternion turn = new Quaternion(0.1f, -0.5f, 0.7f, 0.5f);
        moved.body.transform.rotation = turn;
        moved.body.transform.position = new Vector3(0.3f, -0.2f, 0.5f);
        still.OnEnable();
        moved.OnEnable();
        float worst = 0, largest = 0;
        foreach (string line in walk)
        {
            string[] words = line.Split(' ');
            here.At = new Vector3((float)FromBits(words[0]), (float)FromBits(words[2]), (float)FromBits(words[1]));
            there.At = moved.body.transform.position + turn * here.At;
            still.Step(0.001);
            moved.Step(0.001);
            if (still.Contact.Out->State != moved.Contact.Out->State) continue; // rounded to touch a tick apart
            worst = Math.Max(worst, (turn * here.Force - there.Force).magnitude);
            largest = Math.Max(largest, here.Force.magnitude);
        }
        Expect(largest > 0.1f && worst < 2e-3f * largest, "forces turn with the body: " + worst + " of " + largest + " N");
    }

    static void TheSurfaceIsShownOutwardAndMoves(PalpateAsset asset)
    {
        Device device = new Device();
        PalpateTool tool = MakeTool(asset, device, 0.004f, 0);
        UnityEngine.Mesh mesh = tool.body.GetComponent<MeshFilter>().sharedMesh;
        double volume = 0;
        for (int c = 0; c < mesh.triangles.Length; c += 3)
            volume += Vector3.Dot(mesh.vertices[mesh.triangles[c]],
                Vector3.Cross(mesh.vertices[mesh.triangles[c + 1]], mesh.vertices[mesh.triangles[c + 2]])) / 6;
        Expect(volume > 0, "triangles are clockwise from outside on left-handed axes; volume " + volume);
        if (asset.Engine.Info.HasShape == 0) return;
        tool.OnEnable();
        Vector3[] before = (Vector3[])mesh.vertices.Clone();
        Palpate.Info info = asset.Engine.Info;
        for (double z = info.BoxMaxM[2] + 0.005; z > info.BoxMinM[2]; z -= 2.5e-5)
        {
            device.At = PalpateAxes.ToUnity((info.BoxMinM[0] + info.BoxMaxM[0]) / 2,
                (info.BoxMinM[1] + info.BoxMaxM[1]) / 2, z);
            tool.Step(0.001);
            if (tool.Contact.Out->NormalM > 0.002) break;
        }
        tool.body.LateUpdate();
        float down = 0;
        for (int v = 0; v < before.Length; ++v) down = Math.Min(down, mesh.vertices[v].y - before[v].y);
        Expect(down < -0.001f, "the surface goes down under the tool, by " + down + " m");
    }

    // A mesh of every vertex twice, last first, turned and moved with its object, as it lies on the body.
    static void AMeshOfOnesOwnIsMoved(PalpateAsset asset)
    {
        Palpate.Info info = asset.Engine.Info;
        if (info.VisualVertices == 0) return;
        PalpateVisual visual = new PalpateVisual();
        visual.transform.rotation = new Quaternion(0.1f, -0.5f, 0.7f, 0.5f);
        visual.transform.position = new Vector3(0.3f, -0.2f, 0.5f);
        float[] place = asset.Engine.PlaceVisual(null);
        int count = place.Length / 3;
        Vector3[] vertices = new Vector3[2 * count];
        for (int v = 0; v < vertices.Length; ++v)
        {
            int i = count - 1 - v % count;
            vertices[v] = visual.transform.InverseTransformPoint(
                PalpateAxes.ToUnity(place[3 * i], place[3 * i + 1], place[3 * i + 2]));
        }
        UnityEngine.Mesh own = new UnityEngine.Mesh { vertices = vertices };
        visual.GetComponent<MeshFilter>().sharedMesh = own; // the stubs' one filter: the body's comes after it
        PalpateBody body = new PalpateBody { asset = asset, visual = visual };
        int said = Debug.Said.Count;
        body.OnEnable();
        Expect(Debug.Said.Count == said, "every vertex is found where it lies");
        float[] displacement = new float[3 * info.Vertices];
        for (int v = 0; v < info.Vertices; ++v) displacement[3 * v + 2] = -0.003f; // Unity's y
        Vector3[] before = (Vector3[])own.vertices.Clone();
        visual.Show(displacement);
        float worst = 0;
        for (int v = 0; v < before.Length; ++v)
            worst = Math.Max(worst, (visual.transform.TransformPoint(own.vertices[v]) -
                visual.transform.TransformPoint(before[v]) - new Vector3(0, -0.003f, 0)).magnitude);
        Expect(worst < 1e-6f, "a mesh of one's own goes along with the surface; off by " + worst + " m");
    }

    static void AThreadTicks(PalpateAsset asset)
    {
        Device device = new Device();
        PalpateTool tool = MakeTool(asset, device, 0.004f, 1000);
        tool.OnEnable();
        for (int frame = 0; frame < 20; ++frame)
        {
            Thread.Sleep(16);
            tool.Update();
            tool.body.LateUpdate();
        }
        tool.OnDisable();
        long ticks = tool.Ticks;
        Thread.Sleep(20);
        Expect(ticks > 50 && ticks < 2000, "a thread ticks some 320 times in 320 ms: " + ticks);
        Expect(tool.Ticks == ticks && device.Reads == ticks, "and no more once the tool is disabled");
    }

    static void WithoutADeviceTheToolGoesWhereItsTransformIs(PalpateAsset asset)
    {
        PalpateTool tool = MakeTool(asset, null, 0.004f, 0);
        tool.OnEnable();
        tool.transform.position = new Vector3(0.16f, 0, 0);
        tool.Update();
        for (int tick = 0; tick < 8; ++tick) tool.Step(1.0 / 960);
        Expect(Math.Abs(tool.Contact.In->Tool.PositionM[0] - 0.08) < 1e-3, "half a frame later it is half way");
        for (int tick = 0; tick < 10; ++tick) tool.Step(1.0 / 960);
        Expect(tool.Contact.In->Tool.PositionM[0] == 0.16f, "and then there");
    }

    static PalpateAsset Imported(string path, bool isGood)
    {
        UnityEditor.AssetImporters.AssetImportContext context =
            new UnityEditor.AssetImporters.AssetImportContext { assetPath = path };
        new PalpImporter().OnImportAsset(context);
        Expect(context.Errors.Count == (isGood ? 0 : 1), "the importer says " + (isGood ? "nothing" : "what is wrong"));
        foreach (string error in context.Errors) if (isGood) Console.WriteLine(error);
        return (PalpateAsset)context.Main;
    }

    public static int Main(string[] arguments)
    {
        string[] walk = File.ReadAllLines(arguments[1]);
        PalpateAsset asset = Imported(arguments[0], true);
        string damaged = arguments[1] + ".damaged.palp";
        byte[] content = File.ReadAllBytes(arguments[0]);
        content[content.Length / 2] ^= 1;
        File.WriteAllBytes(damaged, content);
        Imported(damaged, false);
        OutputsHaveTheBitsOfC(asset.Engine, walk);
        if (arguments.Length > 2)
        {
            TwoToolsHaveTheBitsOfC(asset.Engine, File.ReadAllLines(arguments[2]));
            ToolsFeelEachOther(asset);
        }
        else // a closed body
        {
            ForcesTurnWithTheBody(asset, walk);
            TheSurfaceIsShownOutwardAndMoves(asset);
            AMeshOfOnesOwnIsMoved(asset);
        }
        AToolSwapsAxes(asset, walk);
        AThreadTicks(asset);
        WithoutADeviceTheToolGoesWhereItsTransformIs(asset);
        GC.Collect();
        GC.WaitForPendingFinalizers();
        Console.WriteLine(walk.Length + " ticks, " + failures + " claims do not hold");
        return failures;
    }
}
