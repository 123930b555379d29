// An opened asset and a contact on it, in native memory, of which the garbage collector knows
// nothing but when to free it. No Unity here: .NET programs take these two files alone. MIT licence.
using System;
using System.Runtime.InteropServices;

/// An opened .palp. Shared by any number of contacts and threads; freed with the last that uses it.
public sealed unsafe class PalpateEngine
{
    readonly IntPtr room;
    internal readonly Palpate.Asset* Asset;
    public readonly Palpate.Info Info;
    public readonly Palpate.Mesh Mesh;

    /// Throws ArgumentException, with the engine's sentence, on bytes that are no asset.
    public PalpateEngine(byte[] content)
    {
        Check(Palpate.HeaderFits());
        ulong size = (ulong)content.Length, roomBytes = size + 63;
        room = Marshal.AllocHGlobal((IntPtr)(sizeof(Palpate.Asset) + (long)roomBytes));
        Asset = (Palpate.Asset*)room;
        fixed (byte* bytes = content)
            Check(Palpate.palpate_open(Asset, Palpate.palpate_copy_aligned(Asset + 1, roomBytes, bytes, size), size));
        fixed (Palpate.Info* info = &Info) Palpate.palpate_describe(Asset, info);
        fixed (Palpate.Mesh* mesh = &Mesh) Palpate.palpate_read_mesh(Asset, mesh);
    }

    /// Where the vertices of a mesh of one's own are [m], three floats each in the body's axes.
    /// displacementM: of all vertices of the surface; null: at rest.
    public float[] PlaceVisual(float[] displacementM)
    {
        float[] place = new float[3 * Info.VisualVertices];
        if (displacementM != null && displacementM.Length != 3 * Info.Vertices)
            throw new ArgumentException("3 floats a vertex of the surface");
        fixed (float* by = displacementM, to = place)
            if (place.Length > 0) Check(Palpate.palpate_place_visual(Asset, by, 0, Info.VisualVertices, to));
        return place;
    }

    ~PalpateEngine() { Marshal.FreeHGlobal(room); }

    internal static void Check(int status)
    {
        if (status != Palpate.Ok) throw new ArgumentException(Palpate.Sentence(status));
    }
}

/// One tool on an asset, or several that are ticked together and feel each other; used by one thread
/// at a time. Fill In[k], call Tick, read Out[k].
public sealed unsafe class PalpateContact
{
    readonly PalpateEngine engine;
    readonly Palpate.Contact* contacts;
    readonly Palpate.Contact*[] copies = new Palpate.Contact*[3];
    readonly PalpateSlots slots = new PalpateSlots();
    public readonly int Count;
    public readonly Palpate.Input* In;
    public readonly Palpate.Output* Out;

    public PalpateContact(PalpateEngine engine, params Palpate.Tool[] tools)
    {
        this.engine = engine;
        Count = tools.Length;
        int bytes = Count * (4 * sizeof(Palpate.Contact) + sizeof(Palpate.Input) + sizeof(Palpate.Output));
        contacts = (Palpate.Contact*)Marshal.AllocHGlobal(bytes);
        for (byte* b = (byte*)contacts; b < (byte*)contacts + bytes; ++b) *b = 0;
        for (int i = 0; i < 3; ++i) copies[i] = contacts + (1 + i) * Count;
        In = (Palpate.Input*)(contacts + 4 * Count);
        Out = (Palpate.Output*)(In + Count);
        for (int k = 0; k < Count; ++k)
        {
            In[k].Tool.OrientationWxyz[0] = In[k].Body.OrientationWxyz[0] = 1;
            In[k].DtS = 0.001;
            Palpate.Tool tool = tools[k];
            PalpateEngine.Check(Palpate.palpate_start(contacts + k, &tool));
        }
    }

    ~PalpateContact() { Marshal.FreeHGlobal((IntPtr)contacts); }

    /// 0, or the first status whose Palpate.Sentence says what is wrong; that tool has no force then.
    public int Tick()
    {
        int status = Palpate.palpate_tick(engine.Asset, contacts, Count, In, Out);
        for (int k = 0; k < Count; ++k) copies[slots.Writing][k] = contacts[k]; // 30 kB each
        slots.Publish();
        GC.KeepAlive(this);
        return status;
    }

    /// As after a jump that was meant.
    public void Release()
    {
        for (int k = 0; k < Count; ++k) Palpate.palpate_release(contacts + k);
        GC.KeepAlive(this);
    }

    /// For the thread that draws, while another ticks: how far the tools have moved vertices `first` on
    /// [m], three floats each in the body's axes. False where the asset does not say, or nothing is new.
    public bool Deform(int first, int count, float[] displacementM)
    {
        if (displacementM.Length < 3 * count) throw new ArgumentException("room for 3 floats a vertex");
        if (!slots.Take()) return false;
        bool isThere;
        fixed (float* to = displacementM)
            isThere = Palpate.palpate_deform(engine.Asset, copies[slots.Reading], Count, first, count, to) == Palpate.Ok;
        GC.KeepAlive(this);
        return isThere;
    }
}

/// Three slots between a thread that writes and one that reads: neither waits for the other.
public sealed class PalpateSlots
{
    const int Fresh = 4;
    int latest = 2;
    public int Writing { get; private set; }
    public int Reading { get; private set; }

    public PalpateSlots() { Reading = 1; }
    public void Publish() { Writing = System.Threading.Interlocked.Exchange(ref latest, Writing | Fresh) & 3; }
    /// Whether something new was published; it is in Reading then.
    public bool Take()
    {
        if ((System.Threading.Volatile.Read(ref latest) & Fresh) == 0) return false;
        Reading = System.Threading.Interlocked.Exchange(ref latest, Reading) & 3;
        return true;
    }
}
