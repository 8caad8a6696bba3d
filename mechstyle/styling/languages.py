"""Words of other languages for what a prompt may ask for: one table, which stands for the English words of `vocabulary` and the styles."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

LANGUAGES = ("German", "French", "Spanish", "Portuguese", "Italian", "Chinese", "Japanese")
"""The columns of TABLE after the English word."""

TABLE = """
picture | Bild Foto | image photo | imagen foto | imagem foto | immagine foto | 图片 照片 | 画像 写真
bamboo | Bambus Bambusrohr | bambou | bambú bambu caña | bambu cana | bambù canne | 竹 竹子 | 竹 バンブー
basket_weave | Korbgeflecht Flechtwerk Korb Flechtkorb geflochten Weide Rattan | vannerie osier panier tressage tressé rotin | cesta mimbre cestería trenzado ratán | cesto vime cestaria trançado entrançado | cesto vimini intreccio intrecciato rattan | 编织 藤编 篮子 竹编 | 籠 かご 籠目 編み籠 籐 竹編み 竹籠
brick | Ziegel Backstein Klinker Ziegelstein Ziegelmauer Mauerwerk Backsteine Ziegelsteine | brique briques maçonnerie | ladrillo ladrillos mampostería | tijolo tijolos alvenaria | mattone mattoni laterizio muratura | 砖 砖块 砖墙 红砖 砖头 | レンガ 煉瓦 れんが
cactus | Kaktus Kakteen | cactus | cactus cacto nopal | cacto cactos | cactus | 仙人掌 | サボテン
circuit | Platine Leiterplatte Schaltkreis Elektronik | circuit circuit_imprimé électronique | circuito placa_de_circuito electrónica | circuito placa_de_circuito eletrônica eletrónica | circuito circuito_stampato elettronica | 电路 电路板 | 回路 基板 電子回路
cracked_earth | Trockenrisse rissig Risserde rissige_Erde trockene_Erde | terre_craquelée terre_sèche craquelé craquelée | tierra_agrietada tierra_seca agrietado agrietada | terra_rachada terra_seca rachado rachada | terra_secca terra_screpolata screpolato screpolata | 干裂 龟裂 干裂的土地 裂土 | ひび割れ 干上がった大地 乾いた大地
crochet | Häkeln gehäkelt Häkelei Häkelarbeit | crocheté au_crochet | ganchillo croché tejido_a_ganchillo | crochê croché | uncinetto all_uncinetto | 钩针 钩织 | かぎ針編み かぎ針 クロシェ
damascus | Damast Damaststahl Damaszener Damaszenerstahl | damas acier_damas damassé | damasco acero_de_damasco | damasco aço_damasco aço_de_damasco | damasco acciaio_damasco acciaio_di_damasco | 大马士革 大马士革钢 | ダマスカス ダマスカス鋼
dragon_scales | Drachenschuppen Drachenhaut Drache | écailles_de_dragon dragon | escamas_de_dragón dragón | escamas_de_dragão dragão | scaglie_di_drago squame_di_drago drago | 龙鳞 龙 | 竜の鱗 龍の鱗 ドラゴンの鱗 ドラゴン 竜鱗
fish_scales | Fischschuppen Schuppen Schuppe Fisch | écailles_de_poisson écailles écaille poisson | escamas_de_pez escamas escama pez | escamas_de_peixe escamas escama peixe | squame_di_pesce squame scaglie squama scaglia pesce | 鱼鳞 鳞片 | 魚の鱗 鱗 うろこ 魚鱗
floral | Blumen Blume Blüten Blüte geblümt Blumenmuster | fleur fleurs floral florale fleuri | flor flores floral florido | flor flores floral florido | fiore fiori floreale | 花 花朵 花卉 花纹 | 花 花柄 フローラル
leaf | Blätter Blatt Laub Efeu Blattwerk | feuille feuilles feuillage lierre | hoja hojas hiedra follaje | folha folhas hera folhagem | foglia foglie edera fogliame | 树叶 叶子 常春藤 绿叶 | 葉 葉っぱ 蔦 ツタ
hammered | gehämmert Hammerschlag Metall Stahl Eisen | martelé métal acier fer métallique | martillado metal acero hierro metálico | martelado metal aço ferro metálico | martellato metallo acciaio ferro metallico | 锤纹 锤打 金属 钢 铁 | 鎚目 槌目 金属 鋼 鉄 メタル
honeycomb | Honigwabe Waben Wabe Bienenwabe Sechsecke Sechseck | nid_d_abeille nid_d_abeilles alvéole alvéoles hexagone hexagones rayon_de_miel | panal panal_de_abeja nido_de_abeja hexágono hexágonos | favo favo_de_mel colmeia hexágono hexágonos | nido_d_ape favo alveare esagono esagoni alveolare | 蜂窝 蜂巢 六边形 | ハニカム 蜂の巣 六角形
knit | Strick gestrickt Wolle Strickmuster | tricot tricoté laine maille mailles | punto tejido lana tejido_de_punto | tricô malha tricotado | maglia lana a_maglia lavorato_a_maglia | 针织 编织毛衣 毛线 羊毛 | 編み物 ニット 毛糸 ウール
leather | Leder ledern | cuir | cuero piel | couro | pelle cuoio | 皮革 皮 真皮 | 革 レザー 皮革
mandala | Mandala Mandalas | mandala | mandala mándala | mandala | mandala | 曼陀罗 曼荼罗 | 曼荼羅 マンダラ
marble | Marmor marmoriert | marbre marbré | mármol marmóreo | mármore marmorizado | marmo marmorizzato | 大理石 | 大理石 マーブル
realistic | realistisch alt antik Putz gealtert | réaliste plâtre vieux vieilli ancien | realista yeso envejecido viejo antiguo | realista gesso envelhecido velho antigo | realistico gesso invecchiato vecchio antico | 写实 逼真 石膏 旧 | リアル 写実的 漆喰 石膏 古い
stone | Stein Steine Feldstein Bruchstein Fels Felsen Naturstein Steinmauer Kopfsteinpflaster Kiesel steinern | pierre pierres roche rocher pavé pavés galet galets caillou | piedra piedras roca rocas empedrado guijarros adoquín | pedra pedras rocha calçada seixos | pietra pietre roccia rocce ciottoli ciottolo sasso sassi | 石头 石 岩石 鹅卵石 石块 | 石 岩 石畳 石積み ストーン 石造り
studs | Nieten Niete Noppen Noppe genietet | clou clous rivet rivets clouté | tachuela tachuelas remache remaches | tacha tachas rebite rebites | borchia borchie rivetto rivetti | 铆钉 | 鋲 スタッズ リベット びょう
terracotta | Terrakotta Ton Keramik Töpferei tönern | terre_cuite argile poterie céramique | terracota arcilla barro cerámica alfarería | terracota argila barro cerâmica olaria | terracotta argilla ceramica | 陶土 陶器 赤陶 陶 | テラコッタ 陶器 粘土 素焼き
voronoi | Voronoi Netz Zellen Zelle organisch | voronoï réseau cellules organique | voronoi red_orgánica células orgánico | voronoi rede células orgânico | voronoi rete cellule organico | 泰森多边形 沃罗诺伊 网状 细胞 有机 | ボロノイ 網目 細胞
waves | Wellen Welle gewellt wellig Meer Wasser | vague vagues onde ondes ondulé mer eau | ola olas onda ondas ondulado mar agua | onda ondas ondulado mar água | onda onde ondulato mare acqua | 波浪 海浪 水波 波纹 海 | 波 青海波 海 水 さざ波
weathered | verwittert abblätternd abgeblättert verrostet rostig | patiné érodé délavé | desgastado oxidado desconchado erosionado | desgastado enferrujado descascado | consumato arrugginito scrostato eroso | 风化 斑驳 生锈 剥落 | 風化 錆びた 錆び 剥げた 風化した
wood | Holz hölzern Eiche Nussbaum Kiefer Holzmaserung Maserung | bois en_bois chêne noyer | madera roble nogal pino | madeira carvalho nogueira pinho | legno quercia noce pino | 木 木头 木纹 木材 橡木 | 木 木目 木製 木材 ウッド
knurling | Rändel Rändelung gerändelt Kordelung Rändelmuster | moletage moleté | moleteado | recartilhado serrilhado | zigrinatura zigrinato godronatura | 滚花 | ローレット
carbon_fibre | Kohlefaser Karbon Carbon Kohlenstofffaser Carbonfaser | fibre_de_carbone carbone | fibra_de_carbono carbono | fibra_de_carbono carbono | fibra_di_carbonio carbonio | 碳纤维 | カーボンファイバー 炭素繊維 カーボン
isogrid | Isogrid Dreiecksrippen Dreiecksgitter | isogrid isogrille | isogrid rejilla_triangular | isogrid grade_triangular | isogrid griglia_triangolare | 等边三角网格 三角网格 | アイソグリッド 三角格子
dots | Punkte gepunktet Tupfen | pois à_pois points pointillé | lunares puntos | bolinhas poá pontos | pois puntini a_pois | 圆点 波点 点 | 水玉 ドット
bubbles | Blasen Seifenblasen Blase | bulle bulles | burbuja burbujas | bolha bolhas | bolla bolle | 气泡 泡泡 | 泡 バブル 気泡
crystal | Kristall Kristalle kristallin | cristal cristaux | cristal cristales | cristal cristais | cristallo cristalli | 水晶 晶体 结晶 | 水晶 結晶 クリスタル
stripes | Streifen gestreift | rayure rayures rayé bandes | raya rayas rayado franjas | listras listrado riscas | strisce righe a_strisce a_righe rigato | 条纹 | 縞 縞模様 ストライプ
grid | Gitter Raster kariert Karo | grille quadrillage quadrillé | cuadrícula rejilla cuadriculado | grade quadriculado grelha xadrez | griglia quadrettato | 网格 方格 格子 | 格子 グリッド
twill | Köper Köperbindung Twill | sergé | sarga | sarja | saia_diagonale spigato twill | 斜纹 | 綾織 ツイル 綾織り
low_poly | Low_Poly Lowpoly facettiert Facetten | low_poly facettes à_facettes | low_poly facetas facetado poligonal | low_poly facetado poligonal | low_poly sfaccettato poligonale | 低多边形 低面 | ローポリ 低ポリゴン
cable_knit | Zopfmuster Zopfstrick Zöpfe | torsades maille_torsadée | trenzas punto_de_trenzas ochos | tranças tricô_de_tranças | trecce maglia_a_trecce | 绞花 麻花针织 | 縄編み ケーブル編み アラン編み
bark | Rinde Borke Baumrinde | écorce | corteza corteza_de_árbol | casca_de_árvore cortiça | corteccia | 树皮 | 樹皮
feathers | Federn Feder Gefieder | plume plumes plumage | pluma plumas plumaje | pena penas plumagem | piuma piume piumaggio | 羽毛 | 羽 羽毛 羽根
quilting | gesteppt Steppmuster Steppung Steppnaht Polster | matelassé matelassage capitonné capitonnage | acolchado capitoné | acolchoado matelassê capitonê | trapuntato trapunta capitonné | 绗缝 菱格 | キルティング キルト
celtic_knot | keltischer_Knoten Keltenknoten keltisch | noeud_celtique entrelacs celtique celte | nudo_celta celta | entrelaçado_celta celta | nodo_celtico celtico | 凯尔特结 凯尔特 | ケルト ケルト模様 ケルト結び
concrete | Beton Sichtbeton | béton | hormigón concreto | concreto betão | calcestruzzo cemento | 混凝土 水泥 | コンクリート
brushed_metal | gebürstet gebürstetes_Metall gebürsteter_Stahl | métal_brossé acier_brossé brossé | metal_cepillado acero_cepillado cepillado | metal_escovado aço_escovado escovado | metallo_spazzolato acciaio_spazzolato satinato spazzolato | 拉丝金属 拉丝 拉丝钢 | ヘアライン ヘアライン仕上げ
moss | Moos moosig bemoost | mousse moussu | musgo musgoso | musgo | muschio muschioso | 苔藓 青苔 苔 | 苔 モス
art_deco | Art_Deco Artdeco | art_déco | art_decó | art_déco | art_déco | 装饰艺术 装饰风艺术 | アールデコ アール・デコ
topographic | Höhenlinien topografisch topographisch | topographique courbes_de_niveau lignes_de_niveau | topográfico curvas_de_nivel | topográfico curvas_de_nível | topografico curve_di_livello | 等高线 地形 | 等高線 地形図
red | rot | rouge | rojo roja | vermelho vermelha | rosso rossa rossi rosse | 红 红色 红色的 大红 | 赤 赤い 赤色 レッド
crimson | karminrot karmesin | cramoisi carmin | carmesí | carmesim | cremisi | 绯红 深红 | 深紅 クリムゾン
scarlet | scharlachrot | écarlate | escarlata | escarlate | scarlatto | 猩红 | 緋色 スカーレット
maroon | kastanienbraun | bordeaux_foncé | granate | grená | granata | 栗色 | 栗色 マルーン
burgundy | weinrot burgunder burgunderrot | bordeaux | burdeos vino | bordô vinho | bordeaux | 酒红 酒红色 勃艮第 | ワインレッド バーガンディ ワイン色
ruby | rubinrot rubin | rubis | rubí | rubi | rubino | 宝石红 红宝石 | ルビー
pink | rosa pink | rose | rosa rosado | rosa cor_de_rosa rosado | rosa | 粉 粉色 粉红 粉红色 | ピンク 桃色
rose | rosé rosenrot | vieux_rose | rosa_viejo | rosa_velho | rosa_antico | 玫瑰 玫瑰红 玫红 | 薔薇色 ローズ
rose_gold | roségold | or_rose | oro_rosa | ouro_rosa ouro_rosé | oro_rosa | 玫瑰金 | ローズゴールド
salmon | lachs lachsrosa lachsfarben | saumon | salmón | salmão | salmone | 鲑鱼色 三文鱼色 | サーモンピンク
peach | pfirsich pfirsichfarben | pêche | melocotón durazno | pêssego | pesca | 桃色 | ピーチ
orange | orange | orange | naranja anaranjado | laranja alaranjado | arancione arancio | 橙 橙色 橘色 | オレンジ 橙色
amber | bernstein bernsteinfarben | ambre | ámbar | âmbar | ambra | 琥珀 琥珀色 | 琥珀 琥珀色
rust | rost rostrot | rouille | óxido herrumbre | ferrugem | ruggine | 铁锈色 锈红 | 錆色
copper | kupfer kupfern kupferfarben | cuivre cuivré | cobre cobrizo | cobre | rame ramato | 铜 铜色 紫铜 | 銅 銅色
bronze | bronze bronzefarben | bronze | bronce | bronze | bronzo | 青铜 古铜 古铜色 | 青銅 ブロンズ
brass | messing messingfarben | laiton | latón | latão | ottone | 黄铜 | 真鍮
brown | braun | marron brun brune | marrón castaño café | marrom castanho | marrone bruno | 棕 棕色 褐色 咖啡色 | 茶 茶色 茶色い ブラウン
chocolate | schokolade schokobraun schokoladenbraun | chocolat | chocolate | chocolate | cioccolato | 巧克力 巧克力色 | チョコレート
tan | hellbraun gelbbraun | fauve havane | canela | bronzeado | cuoio_chiaro | 棕褐色 | 黄褐色
beige | beige | beige | beige | bege | beige | 米色 米黄色 | ベージュ
khaki | khaki | kaki | caqui | cáqui | cachi kaki | 卡其 卡其色 | カーキ
sand | sand sandfarben | sable | arena | areia | sabbia | 沙色 沙 | 砂色 砂
cream | creme cremefarben | crème | crema | creme | crema panna | 奶油色 奶油 | クリーム クリーム色
ivory | elfenbein elfenbeinfarben | ivoire | marfil | marfim | avorio | 象牙 象牙色 象牙白 | 象牙色 アイボリー 象牙
yellow | gelb | jaune | amarillo amarilla | amarelo amarela | giallo gialla gialli gialle | 黄 黄色 | 黄 黄色 黄色い
gold | gold golden goldfarben vergoldet | or doré dorée dorés dorées | oro dorado dorada dorados doradas | ouro dourado dourada dourados douradas | oro dorato dorata dorati dorate | 金 金色 黄金 | 金 金色 ゴールド
mustard | senf senfgelb | moutarde | mostaza | mostarda | senape | 芥末黄 芥末 | からし色 マスタード
lime | limette limettengrün limone | citron_vert | lima verde_lima | verde_limão | verde_lime | 青柠 柠檬绿 | ライム
green | grün | vert verte | verde | verde | verde verdi | 绿 绿色 | 緑 緑色 グリーン
forest_green | waldgrün tannengrün | vert_forêt vert_sapin | verde_bosque | verde_floresta | verde_foresta verde_bosco | 森林绿 墨绿 墨绿色 | 深緑
olive | oliv olivgrün | olive vert_olive | oliva verde_oliva aceituna | oliva verde_oliva | oliva verde_oliva | 橄榄 橄榄绿 橄榄色 | オリーブ オリーブ色
emerald | smaragd smaragdgrün | émeraude | esmeralda | esmeralda | smeraldo | 祖母绿 翡翠绿 | エメラルド
jade | jade jadegrün | jade | jade | jade | giada | 玉 翠玉 玉色 | 翡翠 翡翠色
mint | mint minze minzgrün mintgrün | menthe | menta | menta | menta | 薄荷 薄荷绿 | ミント
teal | blaugrün | sarcelle bleu_canard | verde_azulado cerceta | verde_azulado | verde_petrolio ottanio | 蓝绿 水鸭色 | 青緑 鴨の羽色
petrol | petrol | bleu_pétrole pétrole | petróleo azul_petróleo | petróleo azul_petróleo | petrolio blu_petrolio | 石油蓝 | ペトロール
turquoise | türkis türkisfarben türkisblau | turquoise | turquesa | turquesa | turchese | 绿松石 绿松石色 青绿 | ターコイズ トルコ石
aqua | aqua wasserblau | aqua bleu_d_eau | aguamarina | água_marinha | acquamarina | 水绿色 | 水色
cyan | zyan cyan | cyan | cian | ciano | ciano | 青色 青 | シアン
blue | blau | bleu bleue | azul | azul azuis | blu | 蓝 蓝色 | 青 青い 青色 ブルー
sky_blue | himmelblau | bleu_ciel | celeste azul_cielo | azul_celeste azul_céu | celeste azzurro_cielo | 天蓝 天蓝色 | 空色
royal_blue | königsblau | bleu_roi | azul_real azul_rey | azul_real | blu_reale | 宝蓝 宝蓝色 | ロイヤルブルー
baby_blue | babyblau | bleu_layette bleu_bébé | azul_bebé | azul_bebê | celestino azzurro_bebè | 婴儿蓝 | ベビーブルー
steel_blue | stahlblau | bleu_acier | azul_acero | azul_aço | blu_acciaio | 钢蓝 | スチールブルー
navy | marineblau dunkelmarine | marine bleu_marine | azul_marino | azul_marinho | blu_marino blu_navy | 海军蓝 藏青 藏青色 | 紺 紺色 ネイビー
sapphire | saphir saphirblau | saphir | zafiro | safira | zaffiro | 宝石蓝 蓝宝石 | サファイア
azure | azur azurblau | azur | azur | azur anil | azzurro azzurra | 蔚蓝 天青 | 紺碧
indigo | indigo indigoblau | indigo | índigo añil | índigo | indaco | 靛蓝 靛青 | 藍 藍色 インディゴ
purple | lila purpur | pourpre | morado morada púrpura | roxo roxa púrpura | porpora | 紫 紫色 | 紫 紫色 パープル
violet | violett veilchenblau | violet violette | violeta | violeta | viola | 紫罗兰 | すみれ色 バイオレット
lilac | flieder fliederfarben | lilas | lila | lilás | lilla | 丁香色 丁香紫 | ライラック
lavender | lavendel | lavande | lavanda | lavanda | lavanda | 薰衣草 薰衣草紫 | ラベンダー 藤色
plum | pflaume pflaumenblau | prune | ciruela | ameixa | prugna | 梅红 李子色 | プラム
magenta | magenta | magenta | magenta | magenta | magenta | 洋红 品红 | マゼンタ
fuchsia | fuchsia | fuchsia | fucsia | fúcsia | fucsia | 紫红色 紫红 | フクシア
white | weiß weiss | blanc blanche blancs blanches | blanco blanca | branco branca | bianco bianca bianchi bianche | 白 白色 | 白 白い 白色 ホワイト
off_white | naturweiß cremeweiß | blanc_cassé | blanco_roto | branco_sujo off_white | bianco_sporco bianco_panna | 米白 米白色 | オフホワイト
silver | silber silbern silberfarben | argent argenté argentée | plata plateado plateada | prata prateado prateada | argento argentato argentata | 银 银色 | 銀 銀色 シルバー
chrome | chrom verchromt | chrome chromé | cromo cromado | cromo cromado | cromo cromato | 铬 镀铬 | クローム クロム
platinum | platin | platine | platino | platina | platino | 铂金 白金 | プラチナ 白金
grey | grau | gris grise | gris | cinza cinzento | grigio grigia grigi grigie | 灰 灰色 | 灰色 グレー ねずみ色 鼠色
gunmetal | | gris_canon | gris_plomo | chumbo | canna_di_fucile | 枪灰 枪灰色 | ガンメタル ガンメタ
anthracite | anthrazit | anthracite | antracita | antracite | antracite | 炭灰 | 黒灰色
charcoal | kohlschwarz holzkohle | charbon | carbón | carvão | carbone_nero | 木炭色 | 炭色 チャコール
black | schwarz | noir noire | negro negra | preto preta negro | nero nera neri nere | 黑 黑色 | 黒 黒い 黒色 ブラック
mahogany | mahagoni | acajou | caoba | mogno | mogano | 红木 桃花心木 | マホガニー
tiny | winzig | minuscule minuscules | diminuto minúsculo | minúsculo | minuscolo piccolissimo | 极小 微小 迷你 | 極小 ごく小さい 極小の
small | klein fein kleine | petit petite fin fine | pequeño chico fino | pequeno fino miúdo | piccolo piccola piccoli piccole fine | 小 小的 细 细小 | 小さい 小さな 小 細かい 細かな
wide | breit | large larges | ancho ancha | largo larga | largo larga larghi larghe | 宽 宽的 | 幅広 幅広い
large | groß gross grob | grand grande gros grosse | grande grandes grueso | grande grandes grosso | grande grandi grosso | 大 大的 粗 粗大 | 大きい 大きな 大
huge | riesig gigantisch | énorme géant immense | enorme gigante | enorme gigante | enorme gigante | 巨大 巨大的 超大 | 巨大 巨大な 特大
flat | flach | plat | plano plana | plano plana | piatto piatta | 平 平坦 | 平ら 平らな 平坦
smooth | glatt | lisse lisses | liso lisa | liso lisa | liscio liscia lisci lisce | 光滑 平滑 | なめらか なめらかな 滑らか 滑らかな つるつる
subtle | dezent subtil zart | subtil subtile discret | sutil suave | sutil suave subtil | sottile leggero | 微妙 轻微 | 控えめ 控えめな
shallow | seicht sanft weich | peu_profond doux douce | poco_profundo blando | pouco_profundo raso macio | poco_profondo morbido | 浅 柔和 | 浅い 浅 柔らかい
rough | rau rauh | rugueux rugueuse brut | áspero rugoso | áspero rugoso | ruvido grezzo | 粗糙 | 粗い ざらざら 荒い
strong | kräftig stark ausgeprägt | fort forte marqué | fuerte marcado | forte marcado | forte marcato | 强烈 明显 | 強い はっきり
deep | tief | profond profonde | profundo profunda | profundo profunda | profondo profonda | 深 深的 | 深い 深く
dark | dunkel düster dunkler dunkle dunkles dunklen | foncé foncée sombre | oscuro oscura | escuro escura | scuro scura scuri scure | 深色 暗 暗色 深色的 | 暗い 濃い ダーク 暗
light | hell helles heller | clair claire | claro clara | claro clara | chiaro chiara chiari chiare | 浅色 亮 浅色的 淡色 | 明るい 薄い ライト 淡い
bright | leuchtend knallig | vif vive | vivo brillante | vivo brilhante | vivace brillante acceso | 鲜艳 明亮 鲜 | 鮮やか 鮮やかな
pale | blass pastell | pâle pastel | pálido pastel | pálido pastel | pallido pastello | 苍白 淡 粉彩 | 淡 パステル
very | sehr | très | muy | muito | molto | 非常 很 十分 | とても 非常に すごく
slightly | leicht etwas | légèrement un_peu | ligeramente un_poco | ligeiramente um_pouco | leggermente un_po | 略微 稍微 有点 | 少し やや わずかに
outside | außen aussen Außenseite Aussenseite äußere draußen | extérieur dehors à_l_extérieur | exterior fuera afuera por_fuera | exterior fora por_fora | esterno fuori all_esterno esterna | 外 外面 外侧 外部 外表面 外壁 | 外側 外 外面 表面
inside | innen Innenseite innere drinnen | intérieur dedans à_l_intérieur | interior dentro adentro por_dentro | interior dentro por_dentro | interno dentro all_interno interna | 里 里面 内侧 内部 内 内壁 | 内側 中 内 内部
rim | Rand Kante Randes | bord rebord | borde | borda beirada aro | bordo orlo | 边缘 口沿 边 沿 | 縁 ふち リム 口縁
top | oben Oberseite obere Oberteil | haut dessus en_haut | arriba superior parte_superior | topo cima superior em_cima parte_de_cima | sopra alto superiore in_alto | 上 顶部 上面 上部 顶 上半部 | 上 上部 上側 上面 上半分 上から
bottom | unten Unterseite untere Unterteil Boden | bas dessous en_bas | abajo inferior fondo parte_inferior | baixo inferior fundo embaixo parte_de_baixo | sotto basso inferiore in_basso fondo | 下 底部 下面 下部 底 下半部 | 下 下部 下側 底 底面 下半分 下から 底から
left | links linke | gauche | izquierda izquierdo | esquerda esquerdo | sinistra sinistro | 左 左边 左侧 | 左 左側
right | rechts rechte | droite droit | derecha derecho | direita direito | destra destro | 右 右边 右侧 | 右 右側
front | vorn vorne Vorderseite vordere | avant devant | frente delante frontal | frente frontal | fronte davanti | 前 前面 正面 | 前 前面 正面
back | hinten Rückseite hintere | arrière derrière | atrás detrás trasera | trás atrás traseira | dietro retro | 后 后面 背面 | 後ろ 背面 裏
sides | Seiten | côtés | lados costados | lados laterais | lati fianchi | 侧面 四周 | 側面
everywhere | überall Rest übrige | partout reste | resto todas_partes | resto toda_parte | resto ovunque dappertutto | 其余 其他 全部 到处 | 残り 全体 その他
above | oberhalb über | au_dessus_de au_dessus | encima_de por_encima_de | acima_de acima | sopra_i al_di_sopra_di | 高于 | より上
below | unterhalb unter | au_dessous_de en_dessous_de | debajo_de por_debajo_de | abaixo_de abaixo | al_di_sotto_di | 低于 | より下
handle | Griff Henkel | poignée anse manche | asa mango | alça cabo pega | manico maniglia | 把手 手柄 | 取っ手 持ち手 ハンドル
plain | schlicht unverziert kahl | uni nu sans_motif | simple sin_decorar | simples sem_decoração | semplice nudo | 素 素面 无花纹 | 無地 プレーン
not | nicht kein keine keinen keiner ohne außer statt anstatt | pas sans sauf ni aucun aucune jamais | no sin excepto salvo menos_el menos_la menos_los menos_las menos_en ni ningún ninguna | não sem exceto menos_o menos_a menos_os menos_as menos_no menos_na nem nenhum nenhuma | non senza tranne eccetto né nessun nessuna | 不 不是 不要 没有 无 除了 别 |
nothing | nichts | rien | nada | nada | niente nulla | 什么都没有 | 何も
not_before | | | | | | 除外 | ではなく じゃなく ではない なし 以外 でなく ではなくて なしで じゃない
but | sondern aber | mais | sino pero | mas senão | ma bensì | 而是 但是 但 而 | しかし
and | und sowie | et | y e | e | e ed | 和 与 以及 跟 | と および そして
with | mit | avec | con | com | con | 带 带有 配 |
seam | Fuge Fugen Naht Nähte Rille Rillen Spalte | joint joints jointure rainure rainures | junta juntas ranura ranuras costura | junta juntas ranhura ranhuras rejunte | fuga fughe giunto giunti scanalatura | 缝 接缝 缝隙 砖缝 | 目地 継ぎ目 溝
background | Grund Hintergrund Untergrund | fond | fondo_liso | base_lisa | sfondo | 底色 背景 | 背景 地色
depth | tief_eingeprägt Relief erhaben geprägt | profondeur relief gravé | profundidad relieve grabado | profundidade relevo gravado | profondità rilievo inciso | 深度 浮雕 高浮雕 | 深さ 浮き彫り レリーフ
mm | Millimeter | millimètre millimètres | milímetro milímetros | milímetro milímetros | millimetro millimetri | 毫米 公厘 | ミリ ミリメートル
cm | Zentimeter | centimètre centimètres | centímetro centímetros | centímetro centímetros | centimetro centimetri | 厘米 公分 | センチ センチメートル
the | der die das den dem des ein eine einen einem einer eines aus von auf im in am an zu für wie nur bitte mach mache soll sein ist bitte Muster Optik Stil Struktur Textur Wand Mauer farben farbig Farbe Look Art werden wird bei zum zur doch auch hoch lieber | le la les un une des du de d l à au aux en sur dans pour comme style motif texture mur couleur seulement juste s qu qui est soit mettre plutôt façon effet aspect de_couleur haut_de | el la los las un una unos unas de del al a en sobre para como estilo textura patrón pared muro color solo sólo que es por_favor tipo efecto lo alto mejor | o a os as um uma uns umas de do da dos das no na nos nas em sobre para como estilo textura padrão parede cor só apenas que por_favor tipo efeito feito feita ao | il lo la i gli le un uno una di del dello della dei degli delle d l a al allo alla ai alle in nel nella nei nelle su sul sulla sui per come stile trama motivo muro parete colore solo soltanto che effetto fatto fatta tipo color | 的 了 是 在 用 风格 纹理 图案 效果 墙 色 做成 样式 只 只有 仅 仅在 个 一 请 样 般 把 做 得 上的 看起来 像 感 质感 部分 要 | の に を は が で へ も だけ のみ 風 模様 調 スタイル です ます な い した して する 柄 壁 色 部分 ように みたいな 感じ ください 仕上げ 大きさ 幅 高さ
""".strip()
"""A row a word: English | the columns of LANGUAGES. Spaces stand between words for the same, "_" between the words of one."""


@cache
def rows() -> tuple[tuple[str, tuple[tuple[str, ...], ...]], ...]:
    """The rows of the table: English word, and the words for it in each language."""
    cells = [[cell.strip() for cell in line.split("|")] for line in TABLE.splitlines()]
    return tuple((english, tuple(tuple(cell.split()) for cell in others)) for english, *others in cells)


@cache
def words_of(language: str) -> Mapping[str, str]:
    """English word that each word of a language stands for, as the table has them."""
    column = LANGUAGES.index(language)
    return {word: english for english, others in rows() for word in others[column]}
